"""Compares the outcomes of two datasets of one study, such as one of another system.

Usage: python same_tables.py DATASET OTHER

Statuses, names and factors are equal, physical outputs within 1e-4 of a column's largest value. What tells of the steps taken,
not of the machine (counters, residuals, times), is left out.
"""

import pathlib
import sys

import pyarrow
import pyarrow.compute
import pyarrow.dataset

TOLERANCE = 1e-4
UNITS = {"J", "Hz", "m/s", "N", "N s", "s"}
LEFT_OUT = ("residual", "scatter", "error", "wall", "step", "drift", "std")


def read(folder, table):
    return pyarrow.dataset.dataset(pathlib.Path(folder) / table).to_table().sort_by("row")


def worst(field, ours, theirs):
    """Largest difference over the column's largest value; infinite where one is null and the other is not."""
    if not pyarrow.types.is_floating(field.type):
        return 0.0 if ours.equals(theirs) else float("inf")
    if not ours.is_null().equals(theirs.is_null()):
        return float("inf")
    size = pyarrow.compute.max(pyarrow.compute.abs(ours)).as_py() or 0.0
    distance = pyarrow.compute.max(pyarrow.compute.abs(pyarrow.compute.subtract(ours, theirs))).as_py() or 0.0
    return distance / size if size > 0.0 else distance


def main(one, other):
    compared, found = 0, 0.0
    ours, theirs = read(one, "runs"), read(other, "runs")
    if ours.schema.names != theirs.schema.names or ours.num_rows != theirs.num_rows or not ours.num_rows:
        sys.exit("same_tables: other columns or rows")
    for field in ours.schema:
        unit = (field.metadata or {}).get(b"unit", b"").decode()
        numeric = pyarrow.types.is_floating(field.type)
        if any(word in field.name for word in LEFT_OUT) or numeric and unit not in UNITS:
            continue
        if pyarrow.types.is_integer(field.type) and "blow" not in field.name:
            continue
        difference = worst(field, ours[field.name], theirs[field.name])
        compared, found = compared + 1, max(found, difference)
        if difference > TOLERANCE:
            sys.exit(f"same_tables: {field.name} differs by {difference:.2g}")
    print(f"same_tables: {ours.num_rows} rows, {compared} columns, at worst {found:.2g} of a column's largest value")


main(*sys.argv[1:])
