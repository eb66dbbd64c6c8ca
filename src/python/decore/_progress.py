"""Progress of a sweep in a terminal or a notebook."""

import sys
from typing import Any

from decore._decore import Progress


class Display:
    """Shows progress: a changing line in a terminal or a notebook, elsewhere only the last line."""

    def __init__(self) -> None:
        self._cell: Any = None
        self._notebook = _in_notebook()

    def __call__(self, progress: Progress) -> None:
        text = line(progress)
        if self._notebook:
            self._show_in_cell(text)
        elif sys.stderr.isatty():
            end = "\n" if progress.ended else ""
            print(f"\r\x1b[K{text}", end=end, file=sys.stderr, flush=True)
        elif progress.ended:
            print(text, file=sys.stderr, flush=True)

    def _show_in_cell(self, text: str) -> None:
        shown = {"text/plain": text}
        if self._cell is None:
            self._cell = sys.modules["IPython"].display.display(shown, raw=True, display_id=True)
        else:
            self._cell.update(shown, raw=True)


def line(progress: Progress) -> str:
    """Progress in words."""
    parts = [f"{progress.done} of {progress.rows} rows"]
    if progress.failed:
        parts.append(f"{progress.failed} not done")
    if progress.ended:
        parts.append(f"{_duration(progress.elapsed_s)}")
    elif progress.seconds_left is not None:
        parts.append(f"{_duration(progress.seconds_left)} left")
    return ", ".join(parts)


def _duration(seconds: float) -> str:
    if seconds < 60.0:
        return f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {rest:02} s"


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return type(shell).__name__ == "ZMQInteractiveShell"
