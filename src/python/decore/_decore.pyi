"""The compiled module; the package's names are those of `decore`."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, SupportsFloat, SupportsIndex, TypeAlias, final

from numpy.typing import ArrayLike

__all__ = [
    "Analysis",
    "Column",
    "Dataset",
    "DatasetError",
    "Error",
    "Factor",
    "Function",
    "MachineError",
    "PredictionWarning",
    "Problem",
    "Progress",
    "Row",
    "Study",
    "StudyError",
    "StudyWarning",
    "Surrogate",
    "SweepError",
    "Table",
    "__version__",
    "open",
]
__version__: str

_Value: TypeAlias = float | int | str
_Path: TypeAlias = str | bytes | PathLike[str] | PathLike[bytes]
# What is taken: numbers of NumPy and of others too.
_Given: TypeAlias = SupportsFloat | SupportsIndex | str
_Setting: TypeAlias = _Given | Sequence[_Setting] | Mapping[str, _Setting]

class Error(Exception):
    """What decore raises; all its exceptions are of this class."""

class StudyError(Error):
    """A study is wrong."""

    problems: list[Problem]
    """Its faults, by place; none where the file could not be read."""

class MachineError(Error):
    """A machine's files cannot be read, or the machine cannot be reduced."""

class DatasetError(Error):
    """A dataset cannot be written or read, or lacks what is asked for."""

class SweepError(Error):
    """Rows could not be run or stored; what is done is kept."""

class StudyWarning(UserWarning):
    """What about a study is possible but unlikely."""

class PredictionWarning(UserWarning):
    """What of a prediction cannot be relied on: rows that are extrapolated, poor models."""

@final
class Problem:
    """One fault of a study."""

    @property
    def file(self) -> str:
        """Name of the file, or the value set over it."""
    @property
    def line(self) -> int | None:
        """Line, from 1; none where the fault belongs to no line."""
    @property
    def column(self) -> int | None:
        """Column in characters, from 1."""
    @property
    def key(self) -> str:
        """Path of the key; empty for a fault of syntax."""
    @property
    def message(self) -> str:
        """What is wrong."""
    @property
    def expected(self) -> str | None:
        """What was expected, where that is not part of the message."""
    @property
    def suggestion(self) -> str | None:
        """The nearest known key or name."""
    @property
    def text(self) -> str:
        """All of it as text, with the line of the file."""

@final
class Column:
    """A column of a table."""

    @property
    def name(self) -> str:
        """Name, with the unit as its suffix."""
    @property
    def unit(self) -> str:
        """Unit; `1` for numbers without one, empty for texts."""
    @property
    def description(self) -> str:
        """What it is."""

@final
class Table:
    """A table: pyarrow, polars, pandas, DuckDB and others take it by the Arrow stream protocol."""

    @property
    def name(self) -> str:
        """Name of the table."""
    @property
    def columns(self) -> list[Column]:
        """Names, units and descriptions of the columns."""
    def __len__(self) -> int: ...
    def __getitem__(self, column: str, /) -> list[float | int | str | None]:
        """The values of a column; no library is needed."""
    def __contains__(self, column: object, /) -> bool:
        """Whether there is a column of this name."""
    def __iter__(self) -> Iterator[str]:
        """Names of the columns."""
    def __arrow_c_schema__(self) -> Any: ...
    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any: ...

@final
class Row:
    """How a row ended, and its tables."""

    @property
    def status(self) -> Literal["done", "audit_failed", "invalid", "diverged", "budget_exhausted"]:
        """How it ended."""
    @property
    def reason(self) -> str:
        """Why the row is not done; empty if it is."""
    @property
    def wall_time_s(self) -> float:
        """Time that it took, in s."""
    @property
    def runs(self) -> Table:
        """Its row of the table of runs."""
    @property
    def blows(self) -> Table:
        """Its blows."""
    @property
    def signals(self) -> Table | None:
        """Its signals; none unless they were asked for and the row could be simulated."""
    def __getitem__(self, column: str, /) -> float | int | str | None:
        """The value of a column of the table of runs."""

@final
class Factor:
    """A factor of a design."""

    @property
    def name(self) -> str:
        """Name as in the study."""
    @property
    def unit(self) -> str | None:
        """Its unit, if the study names one."""
    @property
    def paths(self) -> list[str]:
        """Paths of the study that it drives."""
    @property
    def values(self) -> list[_Value]:
        """The values that it chooses from; empty for a range."""
    @property
    def range(self) -> tuple[float, float] | None:
        """The ends of its range; none for texts and derived factors."""
    @property
    def expression(self) -> str | None:
        """The expression of a derived factor."""

@final
class Function:
    """`f(X) -> Y`: a row of X per point, a column per factor; a row of Y per point, a column per output.

    NaN where a point could not be simulated or a factor does not take its value (NaN, infinity, a masked one, one between whole numbers
    or listed values). Without the axis of points for one point, without that of outputs where one output was
    asked for by its name alone: a float where both are left out. Needs numpy.
    """

    @property
    def factors(self) -> list[str]:
        """Names of the factors, the columns of X."""
    @property
    def outputs(self) -> list[str]:
        """Names of the outputs, the columns of Y."""
    @property
    def bounds(self) -> Sequence[tuple[float, float]]:
        """The ends of each factor's range, as SciPy's optimisers take them."""
    def __call__(self, x: ArrayLike, /) -> Any:
        """The outputs at the points of X, computed on several threads without holding the interpreter."""

@final
class Progress:
    """How far a sweep is."""

    @property
    def rows(self) -> int:
        """Rows that the dataset is to hold."""
    @property
    def done(self) -> int:
        """Rows that are there, whatever their status."""
    @property
    def failed(self) -> int:
        """Of these, rows with another status than done."""
    @property
    def elapsed_s(self) -> float:
        """Time since the sweep was called, in s."""
    @property
    def seconds_left(self) -> float | None:
        """Time left at this rate in s; none before the first row."""
    @property
    def ended(self) -> bool:
        """Whether no more rows are run."""

@final
class Analysis:
    """What was found of the factors of a dataset; `str` has it in words."""

    @property
    def table(self) -> Table:
        """A row per output and index."""
    @property
    def json(self) -> str:
        """As JSON (schemas/sensitivity.schema.json)."""
    @property
    def text(self) -> str:
        """In words, as `decore analyse` prints it."""

@final
class Dataset:
    """A dataset as it was when it was opened."""

    @property
    def runs(self) -> Table:
        """A row per run."""
    @property
    def blows(self) -> Table:
        """A row per blow."""
    @property
    def timings(self) -> Table:
        """Wall time of each run."""
    @property
    def signals(self) -> Table | None:
        """Means of signals, a row per instant of the runs whose signals the study keeps (`[outputs] signals`); None where it keeps none."""
    @property
    def folder(self) -> Path:
        """The folder."""
    @property
    def study_name(self) -> str:
        """Name of the study."""
    @property
    def study_text(self) -> str:
        """Text of the study file."""
    @property
    def overrides(self) -> list[str]:
        """The values set over the study's, `path=value`."""
    @property
    def seed(self) -> int:
        """Seed of the design."""
    @property
    def rows(self) -> int:
        """Rows that the dataset is to hold."""
    @property
    def rows_done(self) -> int:
        """Rows that are there, whatever their status."""
    @property
    def rows_failed(self) -> int:
        """Of these, rows with another status than done."""
    def analyse(
        self,
        outputs: Sequence[str] = ...,
        *,
        estimator: Literal["salib", "jansen", "martinez"] | None = None,
        given: bool = False,
        bootstrap: int = 1000,
        seed: int = 0,
    ) -> Analysis:
        """Which factor matters to which output: as `decore analyse`."""
    def surrogate(self, outputs: Sequence[str] = ..., *, least_q2: float = ...) -> Surrogate:
        """Models of the outputs over the factors: as `decore surrogate`. Below a Q2 of `least_q2` (0.9 unless given) a model warns."""

@final
class Surrogate:
    """Models of the outputs of a dataset over its factors; `str` has them in words."""

    def __new__(cls, file: _Path) -> Surrogate:
        """Reads the file of models that `save` or `decore surrogate --output` wrote."""
    def save(self, file: _Path) -> None:
        """Writes the models to a Parquet file, as `decore surrogate --output`."""
    def predict(self, factors: Mapping[str, Iterable[_Given]]) -> Table:
        """What rows would give that were not run: a list of values for each factor; as `decore predict`.

        Warns by `PredictionWarning` of rows that are extrapolated (column `extrapolated`) and of models that are poor.
        """
    @property
    def warnings(self) -> list[str]:
        """What cannot be relied on, a sentence each."""
    @property
    def json(self) -> str:
        """The models' figures as JSON (schemas/surrogate.schema.json)."""
    @property
    def text(self) -> str:
        """In words, as `decore surrogate` prints it."""

@final
class Study:
    """A study, held to its machine. The machine is reduced when the first row is run."""

    def __new__(
        cls,
        path: _Path,
        overrides: Mapping[str, _Setting] | None = None,
        *,
        retries: int = ...,
    ) -> Study:
        """Reads a study file, with values set over its own by their paths: `{"hammer.left.supply_bar": 4.5}`.

        Raises `StudyError` with all faults, `MachineError` where the machine's files cannot be read. `retries`: times a row that
        diverged is run again (1 unless given), each with a hundredth of the tolerance before.
        """
    @property
    def title(self) -> str:
        """Title of the study."""
    @property
    def hash(self) -> str:
        """Hash over all that determines its rows."""
    @property
    def hammers(self) -> list[str]:
        """Names of the hammers."""
    @property
    def castings(self) -> list[str]:
        """Names of the castings."""
    @property
    def factors(self) -> list[Factor]:
        """The factors of the design."""
    def __len__(self) -> int: ...
    def rows(self) -> Table:
        """The design: a row per run, a column per factor. Nothing is run."""
    def scene(
        self,
        row: SupportsIndex | Mapping[str, _Given],
        *,
        signals: bool | Sequence[str] | None = None,
        signal_interval_s: float = 1e-4,
    ) -> Row:
        """Simulates a row of the design, or one with these values of all factors, by their names.

        `signals`: the names of those that are kept (the time is always), `True` for all. A row that cannot be simulated is no
        error: its status says so.
        """
    def function(
        self,
        outputs: str | Sequence[str],
        *,
        factors: Sequence[str] | None = None,
        fixed: Mapping[str, _Given] | None = None,
        threads: int = 0,
    ) -> Function:
        """Outputs (columns of the table of runs) as a function of factors, over arrays.

        `factors`: the columns of X; all that are not in `fixed` unless named. `fixed`: values of the others, texts among them.
        `threads`: 0 for one per core, or `RAYON_NUM_THREADS`.
        """
    def run(
        self,
        output: _Path,
        *,
        threads: int = 0,
        progress: bool | Callable[[Progress], object] | None = None,
        replace: bool = False,
        max_failed: int | None = None,
    ) -> Dataset:
        """Runs the rows that the dataset in `output` does not hold yet; the same call again goes on.

        `progress`: `True` shows it in the terminal or the notebook, a callable is called with it. Ctrl-C returns at once; rows that
        ended are kept. The files are those that the command line writes.
        """

def open(dataset: _Path) -> Dataset:
    """Opens the dataset in a folder."""
