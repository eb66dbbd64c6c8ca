"""Results of commands: attributes, a dict, words, HTML."""

import json
from html import escape
from typing import Any

from decore._decore import Table

# Lines and rows of one screen.
_LINES = 40
_ROWS = 12


class Record:
    """A part of a result: its values are attributes."""

    def __init__(self, values: dict[str, Any]) -> None:
        self._values = values

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._values:
            known = ", ".join(self.__dict__.get("_values", ()))
            raise AttributeError(f"no attribute `{name}`; known: {known}")
        return _wrapped(self._values[name])

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._values]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and self._values == other._values

    __hash__ = None  # type: ignore[assignment]

    def to_dict(self) -> dict[str, Any]:
        """The values as plain dicts, lists, numbers and texts.

        >>> dataset.verify().to_dict()["whole"]
        True
        """
        return self._values

    def __repr__(self) -> str:
        return screen(json.dumps(self._values, indent=1))

    def _repr_html_(self) -> str:
        return _html(self._values)


class Result(Record):
    """Result of a command of the command line: the keys of its JSON are attributes, `str` describes it in words.

    `json`: as the command prints it with ``--json`` (schemas/). `text`: in words. `notes`: lines that the command line
    prints on standard error. `exit_code`: the command line's (`decore --help`). `table`: the indices of `analyse` as a table.

    >>> report = dataset.report(best=1)
    >>> report.rows, len(report.best)
    (24, 1)
    """

    def __init__(self, command: str, json_text: str, text: str, notes: list[str], exit_code: int, table: Table | None) -> None:
        values = json.loads(json_text)
        # One dataset was asked for, of a command that takes several.
        super().__init__(values[0] if isinstance(values, list) else values)
        self._command = command
        self._own = {"json": json_text, "text": text, "notes": notes, "exit_code": exit_code, "table": table}

    def __getattr__(self, name: str) -> Any:
        own = self.__dict__.get("_own", {})
        return own[name] if name in own and name not in self._values else super().__getattr__(name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._own]

    def __str__(self) -> str:
        return str(self._own["text"] or json.dumps(self._values, indent=1))

    def __repr__(self) -> str:
        return screen(f"<decore.Result of {self._command}>\n{self}")

    def _repr_html_(self) -> str:
        return f"<b>decore {escape(self._command)}</b>{words_html(str(self))}<details><summary>all values</summary>{_html(self._values)}</details>"


def words_html(text: str) -> str:
    """A text whose columns stay below each other; a long one scrolls."""
    return f"<pre style='font-family:monospace;max-height:40em;overflow:auto'>{escape(text)}</pre>"


def table_html(self: Table) -> str:
    """The first rows of a table with units."""
    names = self.keys()
    head = "".join(f"<th>{escape(name)}<br><small>{escape(self.units[name])}</small></th>" for name in names)
    columns = [self.head(name, _ROWS) for name in names]
    rows = "".join(f"<tr>{''.join(f'<td>{_cell(value)}</td>' for value in row)}</tr>" for row in zip(*columns))
    return f"<div style='overflow-x:auto'><table><tr>{head}</tr>{rows}</table></div><small>{len(self)} rows, {len(names)} columns</small>"


def _wrapped(value: Any) -> Any:
    if isinstance(value, dict):
        return Record(value)
    return [_wrapped(one) for one in value] if isinstance(value, list) else value


def screen(text: str) -> str:
    lines = text.splitlines()
    rest = [f"... ({len(lines) - _LINES} more lines; print it, or use to_dict())"] if len(lines) > _LINES else []
    return "\n".join(lines[:_LINES] + rest)


def _html(value: Any) -> str:
    if isinstance(value, dict):
        rows = "".join(f"<tr><th>{escape(str(key))}</th><td>{_html(one)}</td></tr>" for key, one in value.items())
        return f"<table>{rows}</table>"
    if isinstance(value, list):
        shown = ", ".join(_cell(one) if not isinstance(one, (dict, list)) else _html(one) for one in value[:_ROWS])
        return shown + (f" ... ({len(value)})" if len(value) > _ROWS else "")
    return _cell(value)


def _cell(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else escape("" if value is None else str(value))
