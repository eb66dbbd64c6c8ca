"""Opens a table of features with pyarrow, pandas, polars and DuckDB and checks that they see the same as its dictionary and its CSV.

Usage: python features_alike.py FOLDER_WITH_PARQUET FOLDER_WITH_CSV
"""

import csv
import json
import math
import pathlib
import sys

import duckdb
import pandas
import polars
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
        sys.exit(f"features_alike: {message}")


def plain(value):
    """Null, None and NaN of the readers count as one."""
    missing = value is None or value is pandas.NA or (isinstance(value, float) and math.isnan(value))
    return None if missing else value


def check_fields(schema, dictionary):
    """What the fields say is what the dictionary says."""
    check(schema.names == [column["name"] for column in dictionary["columns"]], "names of the dictionary")
    for field, column in zip(schema, dictionary["columns"]):
        metadata = {key.decode(): value.decode() for key, value in field.metadata.items()}
        for key in ["unit", "description", "role", "formula"]:
            check(metadata[key] == column[key], f"{key} of {field.name}")
        check(metadata["derived_from"].split() == column["derived_from"], f"what {field.name} follows from")
        check(str(field.type) == TYPES[column["type"]], f"type of {field.name}: {field.type}")


def check_values(path, names):
    """The readers' values; returns those of pyarrow."""
    arrow = pyarrow.parquet.read_table(path).to_pydict()
    frame = pandas.read_parquet(path)
    lazy = polars.read_parquet(path)
    sql = duckdb.sql(f"select {', '.join(names)} from '{path}' order by row, casting").fetchall()
    for place, name in enumerate(names):
        expected = [plain(value) for value in arrow[name]]
        check([plain(value) for value in frame[name]] == expected, f"{name} in pandas")
        check([plain(value) for value in lazy[name].to_list()] == expected, f"{name} in polars")
        order = sorted(range(len(expected)), key=lambda row: (arrow["row"][row], arrow["casting"][row]))
        check([plain(line[place]) for line in sql] == [expected[row] for row in order], f"{name} in DuckDB")
    return arrow


def check_csv(path, arrow, dictionary):
    """The CSV holds the same values."""
    with open(path, newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    for column in dictionary["columns"]:
        name, is_text = column["name"], column["type"] in ("text", "category")
        for line, value in zip(lines, arrow[name], strict=True):
            text = line[name]
            same = text == (value or "") if is_text else (None if text == "" else float(text)) == value
            check(same, f"{name} in the CSV: {text!r}, not {value!r}")


def main(folder, csv_folder):
    dictionary = json.loads((folder / "dictionary.json").read_text(encoding="utf-8"))
    path = folder / dictionary["table"]
    check_fields(pyarrow.parquet.read_schema(path), dictionary)
    arrow = check_values(path, [column["name"] for column in dictionary["columns"]])
    with open(folder / "dictionary.csv", newline="", encoding="utf-8") as file:
        plain_table = list(csv.DictReader(file))
    for line, column in zip(plain_table, dictionary["columns"], strict=True):
        for key in ["name", "type", "unit", "role", "description", "formula"]:
            check(line[key] == column[key], f"{key} of {column['name']} in dictionary.csv")
    check_csv(csv_folder / "features.csv", arrow, dictionary)
    print(f"{len(arrow['row'])} rows of {len(arrow)} columns read alike")


main(*map(pathlib.Path, sys.argv[1:]))
