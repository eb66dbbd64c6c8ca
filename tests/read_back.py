"""Opens a dataset with pyarrow, pandas, polars and DuckDB and checks that they see the same, units included.

Usage: python read_back.py DATASET
"""

import json
import math
import pathlib
import sys

import duckdb
import pandas
import polars
import pyarrow.dataset
import pyarrow.parquet

TYPES = {
    "real": "double",
    "count": "uint64",
    "integer": "int64",
    "text": "string",
    "category": "dictionary<values=string, indices=int32, ordered=0>",
}


def check(condition, message):
    """Unlike `assert`, also checks under `python -O`."""
    if not condition:
        sys.exit(f"read_back: {message}")


def same(a, b):
    """Equal values; null, None and NaN of the readers count as one."""
    missing = [x is None or (isinstance(x, float) and math.isnan(x)) for x in (a, b)]
    return all(missing) or (not any(missing) and a == b)


def check_metadata(folder, table, manifest):
    """Units, descriptions and key-values of every part."""
    for part in sorted((folder / table).glob("*.parquet")):
        file = pyarrow.parquet.ParquetFile(part)
        entries = {key.decode(): value.decode() for key, value in file.metadata.metadata.items()}
        study = manifest["study"]
        for key, expected in [
            ("study_text", study["study_text"]),
            ("study_hash", study["study_hash"]),
            ("seed", str(study["seed"])),
            ("version", study["program_version"]),
        ]:
            check(entries[f"decore.{key}"] == expected, f"{part}: key-value {key}")
            shown = file.schema_arrow.metadata[f"decore.{key}".encode()].decode()
            check(shown == expected, f"{part}: {key} in the schema's metadata")
        dictionary = json.loads(entries["decore.dictionary"])["columns"]
        schema = file.schema_arrow
        check(schema.names == [column["name"] for column in dictionary], f"{part}: names of the dictionary")
        for field, column in zip(schema, dictionary):
            metadata = field.metadata
            check(metadata[b"unit"].decode() == column["unit"], f"{part}: unit of {field.name}")
            check(metadata[b"description"].decode() == column["description"], f"{part}: description of {field.name}")
            check(len(column["description"]) > 0, f"{part}: empty description of {field.name}")
            check(str(field.type) == TYPES[column["type"]], f"{part}: type of {field.name}")
        for group in range(file.metadata.num_row_groups):
            codec = file.metadata.row_group(group).column(0).compression
            check(codec == "ZSTD", f"{part}: compression {codec}")


def read_all(folder, table):
    """The table as each reader sees it: a list of columns per reader."""
    glob = str(folder / table / "*.parquet")
    arrow = pyarrow.dataset.dataset(folder / table, format="parquet").to_table()
    frame = pandas.read_parquet(folder / table)
    lazy = polars.scan_parquet(glob).collect()
    names = arrow.column_names
    quoted = ", ".join(names)  # unquoted on purpose: the names must be safe
    order = "row, hammer, number" if table == "blows" else "row"
    sql = duckdb.sql(f"select {quoted} from '{glob}' order by {order}").fetchall()
    by_arrow = arrow.to_pydict()
    check(list(frame.columns) == names, f"{table}: names in pandas")
    check(lazy.columns == names, f"{table}: names in polars")
    if table == "blows":
        ranks = sorted(range(arrow.num_rows), key=lambda i: tuple(by_arrow[k][i] for k in ("row", "hammer", "number")))
    else:
        ranks = range(arrow.num_rows)
    by_sql = {name: [None] * arrow.num_rows for name in names}
    check(len(sql) == arrow.num_rows, f"{table}: rows in DuckDB")
    for position, values in zip(ranks, sql):
        for name, value in zip(names, values):
            by_sql[name][position] = value
    return by_arrow, {
        "pandas": {name: frame[name].astype(object).tolist() for name in names},
        "polars": lazy.to_dict(as_series=False),
        "duckdb": by_sql,
    }


def compare(folder, table):
    by_arrow, others = read_all(folder, table)
    for reader, columns in others.items():
        for name, values in by_arrow.items():
            other = columns[name]
            check(len(other) == len(values), f"{table}.{name}: {len(other)} rows in {reader}, {len(values)} in pyarrow")
            for row, (a, b) in enumerate(zip(values, other)):
                # pandas has no missing integers: a column with nulls comes as floats, of the same value
                b = None if b is pandas.NA else b
                check(same(a, b), f"{table}.{name}[{row}]: {b!r} in {reader}, {a!r} in pyarrow")
    return by_arrow


def check_mixed(folder):
    """All tables at once are none: what DuckDB does with them is as `decore help reading` has it."""
    glob = f"{folder}/**/*.parquet"
    for query in (f"select avg(delivered_work_j) from '{glob}'", f"select kind, count(*) from '{glob}' group by kind"):
        try:
            duckdb.sql(query).fetchall()
        except duckdb.Error:
            continue
        check(False, f"DuckDB takes all tables for one: {query}")
    count = lambda files: duckdb.sql(f"select count(*) from '{files}'").fetchall()[0][0]
    parts = [count(part.as_posix()) for part in folder.rglob("*.parquet")]
    check(count(glob) == sum(parts), "DuckDB counts the rows of all tables together")


def main():
    folder = pathlib.Path(sys.argv[1])
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    for table in ("runs", "blows", "timings"):
        check_metadata(folder, table, manifest)
    runs, blows, timings = (compare(folder, table) for table in ("runs", "blows", "timings"))

    rows = runs["row"]
    check(len(rows) == manifest["rows_done"], f"{len(rows)} runs, {manifest['rows_done']} in the manifest")
    spans = [row for span in manifest["done"] for row in range(span["first"], span["end"])]
    check(rows == spans, "rows of the runs and of the manifest")
    check(timings["row"] == rows, "rows of the timings")
    check(all(wall >= 0 for wall in timings["wall_time_s"]), "negative wall time")
    done = {row for row, status in zip(rows, runs["status"]) if status == "done"}
    check(set(blows["row"]) <= done, "blows of a row that is not done")
    check(set(blows["hammer"]) <= set(manifest["study"]["hammers"]), "hammers of the blows")
    check(set(blows["casting"]) <= set(manifest["study"]["castings"]), "castings of the blows")
    for row, total, count in zip(rows, runs["delivered_work_in_windows_j"], runs["total_blow_count"]):
        check((total is None) == (row not in done), f"row {row}: work where there is none, or none where there is")
        check(count is None or count >= 0, f"row {row}: {count} blows")

    check_mixed(folder)
    glob = folder / "*" / "*.parquet"
    sums = duckdb.sql(
        f"select r.row, r.delivered_work_in_windows_j, sum(b.work_j), count(*), r.total_blow_count "
        f"from '{folder}/runs/*.parquet' r join '{folder}/blows/*.parquet' b using (row) "
        f"group by r.row, r.delivered_work_in_windows_j, r.total_blow_count order by r.row"
    ).fetchall()
    for row, total, work, count, blow_count in sums:
        check(abs(total - work) <= 1e-9 * max(abs(total), 1.0), f"row {row}: work {total} J, of its blows {work} J")
        check(count == blow_count, f"row {row}: {blow_count} blows, {count} in the table")

    statuses = {status: runs["status"].count(status) for status in sorted(set(runs["status"]))}
    print(f"pyarrow, pandas, polars, duckdb agree on {len(rows)} runs, {len(blows['row'])} blows ({glob})")
    print(f"statuses: {statuses}")
    best = duckdb.sql(
        f"select row, delivered_work_j from '{folder}/runs/*.parquet' "
        f"where status = 'done' order by delivered_work_j desc, row limit 3"
    ).fetchall()
    for row, work in best:
        print(f"row {row}: {work:.4g} J delivered")


main()
