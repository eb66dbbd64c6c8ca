"""Frames of other libraries from tables, and their display in notebooks."""

import math
import tempfile
from collections.abc import Callable, Iterator
from html import escape
from importlib import import_module
from pathlib import Path
from typing import Any

from decore._decore import Dataset, Factor, Row, Study, Table
from decore._result import table_html, words_html

# Rows that took longer are not run again for their picture, in s.
_MOST_DRAWN_S = 20.0


def attach() -> None:
    """Gives the classes their methods."""
    methods: dict[type, list[Callable[..., Any]]] = {Table: [to_pandas, to_polars, to_arrow, __iter__], Row: [to_dict]}
    for owner, own in methods.items():
        for method in own:
            method.__qualname__ = f"{owner.__name__}.{method.__name__}"
            method.__module__ = "decore"
            setattr(owner, method.__name__, method)
    html: dict[type, Callable[..., str]] = {Table: table_html, Row: _row_html, Dataset: _dataset_html, Study: _study_html}
    for owner, shown in html.items():
        setattr(owner, "_repr_html_", shown)


def to_pandas(self: Table, /) -> Any:
    """The table as a pandas frame, with the units in ``frame.attrs["units"]``. Needs pandas and numpy.

    >>> dataset.runs.to_pandas()["delivered_work_j"].count() > 0
    np.True_
    """
    frame = _library("pandas", "to_pandas").DataFrame(self.to_numpy())
    frame.attrs["units"] = self.units
    return frame


def to_polars(self: Table, /) -> Any:
    """The table as a polars frame, without a copy. Needs polars.

    >>> dataset.runs.to_polars().height
    24
    """
    return _library("polars", "to_polars").DataFrame(self)


def to_arrow(self: Table, /) -> Any:
    """The table as a pyarrow table, without a copy, with units and descriptions as metadata. Needs pyarrow.

    >>> dataset.blows.to_arrow().schema.field("work_j").metadata[b"unit"]
    b'J'
    """
    return _library("pyarrow", "to_arrow").table(self)


def __iter__(self: Table, /) -> Iterator[dict[str, Any]]:
    """The rows as dicts: `pandas.DataFrame(table)` reads a table so. Numbers that are not there are NaN.

    >>> next(iter(study.rows()))["row"]
    0
    """
    columns = {name: self[name] for name in self.keys()}
    for name, unit in self.units.items():
        if unit:  # texts have none
            columns[name] = [math.nan if value is None else value for value in columns[name]]
    return (dict(zip(columns, row)) for row in zip(*columns.values()))


def to_dict(self: Row, /) -> dict[str, Any]:
    """The columns of the table of runs and their values.

    >>> study.scene(3).to_dict()["status"]
    'done'
    """
    return {name: self[name] for name in self.keys()}


def _library(name: str, method: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        raise ImportError(f"{method} needs {name}: `pip install {name}`") from error


def _values(factor: Factor) -> str:
    if factor.range is None or factor.values:
        return factor.expression or ", ".join(map(str, factor.values))
    return "{:g} to {:g}".format(*factor.range)


def _row_html(self: Row) -> str:
    """The row's picture and its outputs. A row of the design is run again for the picture."""
    picture = ""
    if self.index is not None and self.wall_time_s < _MOST_DRAWN_S and self.status == "done":
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "row.svg"
            self.study.write_scene(row=self.index, plot=file)
            picture = file.read_text(encoding="utf-8")
    return f"<b>{escape(repr(self))}</b><div>{picture}</div>{table_html(self.runs)}"


def _dataset_html(self: Dataset) -> str:
    return f"<b>{escape(repr(self))}</b>{words_html(str(self.report()))}"


def _study_html(self: Study) -> str:
    factors = [(one.name, one.unit or "", _values(one), ", ".join(one.paths)) for one in self.factors]
    rows = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in factors)
    head = "<tr><th>factor</th><th>unit</th><th>values</th><th>paths</th></tr>"
    return f"<b>{escape(repr(self))}</b><table>{head}{rows}</table>"
