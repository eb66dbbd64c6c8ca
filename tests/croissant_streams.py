"""Validates the Croissant metadata of a table of features and streams its records: they are those of the table, checksums hold.

Usage: python croissant_streams.py FOLDER
"""

import hashlib
import importlib.util
import json
import math
import pathlib
import sys

import pandas


def check(condition, message):
    """Unlike `assert`, also checks under `python -O`."""
    if not condition:
        sys.exit(f"croissant_streams: {message}")


def plain(value):
    """Texts as texts; nothing, NaN and the empty text count as one."""
    if isinstance(value, bytes):
        value = value.decode()
    missing = value is None or value == "" or (isinstance(value, float) and math.isnan(value))
    return None if missing else value


def main(folder):
    metadata = json.loads((folder / "croissant.json").read_text(encoding="utf-8"))
    for file in metadata["distribution"]:
        digest = hashlib.sha256((folder / file["contentUrl"]).read_bytes()).hexdigest()
        check(digest == file["sha256"], f"checksum of {file['contentUrl']}")
    if importlib.util.find_spec("mlcroissant") is None:
        print("mlcroissant is not installed: its validation was not tried")
        return
    import mlcroissant

    dataset = mlcroissant.Dataset(jsonld=folder / "croissant.json")
    check(not dataset.metadata.issues.errors, f"errors: {dataset.metadata.issues.errors}")
    table = metadata["distribution"][0]["name"]
    read = pandas.read_parquet if table.endswith(".parquet") else pandas.read_csv
    frame = read(folder / table)
    count = 0
    for row, record in enumerate(dataset.records("features")):
        for name in frame.columns:
            found, expected = plain(record[f"features/{name}"]), plain(frame[name][row])
            check(found == expected, f"{name} in row {row}: {found!r}, not {expected!r}")
        count += 1
    check(count == len(frame), f"{count} records, {len(frame)} rows")
    print(f"{count} records of {len(frame.columns)} fields stream as they are")


main(pathlib.Path(sys.argv[1]))
