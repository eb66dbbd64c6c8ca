"""Columns by name, from mappings, frames, rows and structured arrays."""

from typing import Any

from decore._decore import Table


def columns(given: Any) -> list[tuple[str, Any]] | None:
    """Return names and values of an object with names; None for numbers without names."""
    if isinstance(given, (list, tuple)):
        return _of_rows(given) if given and hasattr(given[0], "keys") else None
    if isinstance(given, Table):
        return [(name, given[name]) for name in given.keys()]
    if hasattr(given, "fetchnumpy"):  # DuckDB
        return list(given.fetchnumpy().items())
    if hasattr(given, "column_names"):  # Arrow
        return [(name, given.column(place).to_pylist()) for place, name in enumerate(given.column_names)]
    if hasattr(given, "get_columns"):  # polars
        return [(series.name, series) for series in given.get_columns()]
    if hasattr(given, "iloc") and hasattr(given, "columns"):  # pandas, where a name can stand twice
        return [(str(name), given.iloc[:, place]) for place, name in enumerate(given.columns)]
    if hasattr(given, "keys"):  # mappings, rows, and a row of a pandas frame
        names = list(given.keys())
        is_array = hasattr(given, "iloc") and not any(isinstance(name, str) for name in names)
        return None if is_array else [(str(name), given[name]) for name in names]
    fields = getattr(getattr(given, "dtype", None), "names", None)
    return None if fields is None else [(name, given[name]) for name in fields]


def unnamed(given: Any, width: int) -> list[list[Any]]:
    """Columns of rows without names: one row, or a sequence of rows."""
    rows = given.tolist() if hasattr(given, "tolist") else list(given)
    rows = [list(row) for row in rows] if rows and _is_row(rows[0]) else [rows] if rows else []
    for place, row in enumerate(rows):
        if len(row) != width:
            raise ValueError(f"row {place} has {len(row)} values, expected {width}: one per factor, or columns by name")
    return [[row[place] for row in rows] for place in range(width)]


def _is_row(one: Any) -> bool:
    return not isinstance(one, str) and hasattr(one, "__len__") and getattr(one, "ndim", 1) > 0


def _of_rows(rows: Any) -> list[tuple[str, Any]]:
    names = list(rows[0].keys())
    for place, row in enumerate(rows):
        if not hasattr(row, "keys") or set(row.keys()) != set(names):
            raise KeyError(f"row {place} has other names than row 0: {', '.join(map(str, names))}")
    return [(str(name), [row[name] for row in rows]) for name in names]
