"""Opens a dataset with pyarrow, polars and DuckDB again and again while a sweep of the built-in test scene writes it.

Usage: python read_while_growing.py DECORE STUDY

Every reader must see whole rows, each once, never fewer than before, and all of them at the end.
"""

import pathlib
import subprocess
import sys
import tempfile
import time

import duckdb
import polars
import pyarrow.dataset

ROWS = 12_000


def check(condition, message):
    """Unlike `assert`, also checks under `python -O`."""
    if not condition:
        sys.exit(f"read_while_growing: {message}")


def by_arrow(runs):
    return pyarrow.dataset.dataset(runs, format="parquet").to_table(columns=["row"]).column("row").to_pylist()


def by_polars(runs):
    return polars.scan_parquet(str(runs / "*.parquet")).select("row").collect()["row"].to_list()


def by_duckdb(runs):
    return [row for (row,) in duckdb.sql(f"select row from '{runs}/*.parquet'").fetchall()]


def main():
    decore, study = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch) / "growing"
        command = [decore, "run", study, "--stub-row-ms", "1", "--set", f"design.rows={ROWS}", "--output", str(folder)]
        sweep = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        runs = folder / "runs"
        readers = {"pyarrow": by_arrow, "polars": by_polars, "duckdb": by_duckdb}
        seen, looks, growing = dict.fromkeys(readers, 0), 0, set()
        while True:
            over = sweep.poll() is not None
            if any(runs.glob("*.parquet")):
                looks += 1
                for name, read in readers.items():
                    rows = read(runs)
                    check(len(rows) == len(set(rows)), f"{name} sees a row twice")
                    check(all(0 <= row < ROWS for row in rows), f"{name} sees a row that is none")
                    check(len(rows) >= seen[name], f"{name} sees {len(rows)} rows after {seen[name]}")
                    seen[name] = len(rows)
                    if 0 < len(rows) < ROWS and not over:
                        growing.add(len(rows))
            if over:
                break
            time.sleep(0.02)
        check(sweep.returncode in (0, 4), f"the sweep ended with {sweep.returncode}")
        check(all(count == ROWS for count in seen.values()), f"rows at the end: {seen}")
        check(len(growing) >= 2, f"only {len(growing)} sizes were seen while it grew: too few to say anything")
        print(f"{looks} looks by each reader, at {len(growing)} sizes while the dataset grew: whole rows, each once")


if __name__ == "__main__":
    main()
