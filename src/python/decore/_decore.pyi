"""The compiled module; the package's names are those of `decore`."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, Protocol, SupportsFloat, SupportsIndex, TypeAlias, final, type_check_only

import pandas
import polars
import pyarrow
from numpy.typing import ArrayLike, NDArray

from decore._result import Result

__all__ = [
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

@type_check_only
class _HasKeys(Protocol):
    """Mappings, rows, and rows of pandas frames."""

    def keys(self) -> Any: ...
    def __getitem__(self, key: Any, /) -> Any: ...

# What has columns by name, or rows: pandas, polars, Arrow, DuckDB, mappings, sequences of rows.
_Frame: TypeAlias = Any

class Error(Exception):
    """Base class of decore's exceptions."""

class StudyError(Error):
    """A study has errors."""

    problems: list[Problem]
    """Its problems, by place; none if the file could not be read."""

class MachineError(Error):
    """A machine's files cannot be read, or the machine cannot be reduced."""

class DatasetError(Error):
    """A dataset cannot be written or read, or lacks the requested data."""

class SweepError(Error):
    """Rows could not be run or stored. Finished rows are kept."""

class StudyWarning(UserWarning):
    """Possible but unlikely values of a study."""

class PredictionWarning(UserWarning):
    """Unreliable predictions: extrapolated rows, poor models."""

@final
class Problem:
    """One problem of a study."""

    @property
    def file(self) -> str:
        """Name of the file, or the override."""
    @property
    def line(self) -> int | None:
        """Line, from 1; none if the problem has no line."""
    @property
    def column(self) -> int | None:
        """Column in characters, from 1."""
    @property
    def key(self) -> str:
        """Path of the key; empty for a syntax error."""
    @property
    def message(self) -> str:
        """The problem."""
    @property
    def expected(self) -> str | None:
        """Expected value, if it is not part of the message."""
    @property
    def suggestion(self) -> str | None:
        """The nearest known key or name."""
    @property
    def text(self) -> str:
        """The whole problem as text, with the line of the file."""

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
        """Description of the column."""

@final
class Table:
    """A table. pyarrow, polars, pandas, DuckDB and others can read it with the Arrow stream protocol."""

    @property
    def name(self) -> str:
        """Name of the table."""
    @property
    def columns(self) -> list[Column]:
        """Names, units and descriptions of the columns."""
    @property
    def units(self) -> dict[str, str]:
        """Units by the names of the columns: `1` for numbers without one, empty for texts."""
    def keys(self) -> list[str]:
        """Names of the columns."""
    def head(self, column: str, rows: int = 5) -> list[float | int | str | None]:
        """The first values of a column."""
    def to_numpy(self) -> dict[str, NDArray[Any]]:
        """The columns as arrays of NumPy by their names: missing numbers are NaN, texts are objects."""
    def to_pandas(self, /) -> pandas.DataFrame:
        """The table as a pandas frame, with the units in `frame.attrs["units"]`."""
    def to_polars(self, /) -> polars.DataFrame:
        """The table as a polars frame, without a copy."""
    def to_arrow(self, /) -> pyarrow.Table:
        """The table as a pyarrow table, without a copy, with units and descriptions as metadata."""
    def __len__(self) -> int: ...
    def __getitem__(self, column: str, /) -> list[float | int | str | None]:
        """The values of a column; no library is needed."""
    def __contains__(self, column: object, /) -> bool:
        """Whether a column has this name."""
    def __iter__(self, /) -> Iterator[dict[str, Any]]:
        """The rows as dicts."""
    def _repr_html_(self) -> str: ...
    def __arrow_c_schema__(self) -> Any: ...
    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any: ...

@final
class Row:
    """A simulated row: its status and its tables."""

    @property
    def status(self) -> Literal["done", "audit_failed", "invalid", "diverged", "budget_exhausted"]:
        """Status of the row."""
    @property
    def reason(self) -> str:
        """Reason why the row is not done; empty if it is."""
    @property
    def wall_time_s(self) -> float:
        """Wall time of the run in s."""
    @property
    def runs(self) -> Table:
        """Row of the table of runs."""
    @property
    def blows(self) -> Table:
        """Blows of the row."""
    @property
    def signals(self) -> Table | None:
        """Signals; none unless you asked for them and the row could be simulated."""
    @property
    def study(self) -> Study:
        """Study of the row."""
    @property
    def index(self) -> int | None:
        """Row number in the design; none for your own values of factors."""
    def keys(self) -> list[str]:
        """Names of the columns of the table of runs."""
    def to_dict(self, /) -> dict[str, float | int | str | None]:
        """The columns of the table of runs and their values."""
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]: ...
    def __contains__(self, column: object, /) -> bool: ...
    def __getitem__(self, column: str, /) -> float | int | str | None:
        """The value of a column of the table of runs."""
    def _repr_html_(self) -> str: ...

@final
class Factor:
    """A factor of a design."""

    @property
    def name(self) -> str:
        """Name as in the study."""
    @property
    def unit(self) -> str | None:
        """Unit, if the study gives one."""
    @property
    def paths(self) -> list[str]:
        """Paths of the study that it drives."""
    @property
    def values(self) -> list[_Value]:
        """Possible values; empty for a range."""
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
        """The ends of each factor's range, for SciPy's optimisers."""
    def __call__(self, x: ArrayLike | _Frame, /) -> Any:
        """The outputs at the points of X, computed on several threads without holding the interpreter."""

@final
class Progress:
    """Progress of a sweep."""

    @property
    def rows(self) -> int:
        """Number of rows of the complete dataset."""
    @property
    def done(self) -> int:
        """Number of existing rows with any status."""
    @property
    def failed(self) -> int:
        """Number of existing rows that are not done."""
    @property
    def elapsed_s(self) -> float:
        """Time since the sweep was called, in s."""
    @property
    def seconds_left(self) -> float | None:
        """Time left at this rate in s; none before the first row."""
    @property
    def ended(self) -> bool:
        """Whether the sweep has ended."""

@final
class Dataset:
    """A dataset, as it was when you opened it."""

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
        """Means of signals, a row per instant of the runs with stored signals (`[outputs] signals`); None without them."""
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
        """Overrides of the study, `path=value`."""
    @property
    def seed(self) -> int:
        """Seed of the design."""
    @property
    def rows(self) -> int:
        """Number of rows of the complete dataset."""
    @property
    def rows_done(self) -> int:
        """Number of existing rows with any status."""
    @property
    def rows_failed(self) -> int:
        """Number of existing rows that are not done."""
    def surrogate(
        self,
        outputs: str | Sequence[str] = (),
        *,
        output: str | PathLike[str] | None = None,
        replace: bool = False,
        least_q2: float = 0.9,
    ) -> Surrogate:
        """Model the outputs, so that rows not run can be predicted, with intervals; as `decore surrogate`."""
    def __fspath__(self) -> str:
        """Path of the folder, so that you can pass a dataset as a path."""
    def _fit(self, outputs: list[str], least_q2: float) -> Surrogate: ...
    def _repr_html_(self) -> str: ...
    def report(
        self,
        /,
        *,
        rank_by: str = "strike_energy_j",
        best: int = 5,
        html: _Path | None = None,
        replace: bool = False,
        files_in: _Path | None = None,
        wanted_error: float = 0.01,
    ) -> Result:
        """Summarise a dataset: best rows, ranges, distributions."""
    def status(
        self,
        /,
    ) -> Result:
        """Tell how far sweeps are or how they ended."""
    def verify(
        self,
        /,
    ) -> Result:
        """Read all files of datasets and say whether they are whole."""
    def analyse(
        self,
        /,
        outputs: str | Sequence[str] = (),
        *,
        estimator: Literal["salib", "jansen", "martinez"] | None = None,
        given: bool = False,
        bootstrap: int = 1000,
        seed: int = 0,
        study: _Path | None = None,
        repair: bool = False,
        grow_until: float | None = None,
        most_rows: int = 100000,
        overrides: Mapping[str, _Setting] | Sequence[str] = (),
        parquet: _Path | None = None,
        replace: bool = False,
        progress: bool | Callable[[Progress], object] | None = None,
    ) -> Result:
        """Tell which factors matter to a dataset's outputs: Sobol' indices or elementary effects, with intervals."""
    def compare(
        self,
        /,
        second: _Path | Dataset,
        outputs: str | Sequence[str] = (),
        *,
        relative: float = 0.0001,
        most: int = 20,
    ) -> Result:
        """Compare two datasets: rows matched by their factors, outputs beyond their scatter listed."""
    def cores(
        self,
        /,
        output: _Path | None = None,
        *,
        tests: _Path,
        law: Literal["lognormal", "weibull"] = "lognormal",
        best: int = 10,
        replace: bool = False,
    ) -> Result:
        """Find the dose at which cores are out from tests, and the time until the cores of each row are out."""
    def export(
        self,
        /,
        features: _Path,
        *,
        format: str = "parquet",
        dose_threshold_j: float = 0,
        work_j: float | None = None,
        splits: Sequence[float] = (),
        seed: int = 0,
        group_by: Sequence[str] = (),
        replace: bool = False,
    ) -> Result:
        """Write a dataset as a flat table that predictors are trained on, with its dictionary."""
    def scene(
        self,
        /,
        *,
        row: int = 0,
        overrides: Mapping[str, _Setting] | Sequence[str] = (),
        signals: _Path | None = None,
        plot: _Path | None = None,
        html: _Path | None = None,
        replace: bool = False,
        files_in: _Path = ".",
        signal_interval_s: float = 0.0001,
        measured: _Path | None = None,
        channels: Sequence[str] = (),
        time_column: str = "time_s",
        offset_s: float | None = None,
        low_pass_hz: float = 4000,
    ) -> Result:
        """Simulate one row of a study and print all its outputs."""
    def best(
        self,
        /,
        output: _Path | None = None,
        *,
        rows: int = 160,
        checks: int = 100,
        batch: int = 12,
        overrides: Mapping[str, _Setting] | Sequence[str] = (),
        files_in: _Path | None = None,
        progress: bool | Callable[[Progress], object] | None = None,
    ) -> Result:
        """Find the best values for the study's goal, and prove them by runs."""

@final
class Surrogate:
    """Models of the outputs of a dataset over its factors; `str` describes them in words."""

    def __new__(cls, file: _Path) -> Surrogate:
        """Reads the file of models that `save` or `decore surrogate --output` wrote."""
    def _warned(self) -> Surrogate: ...
    def save(self, file: _Path) -> None:
        """Writes the models to a Parquet file, as `decore surrogate --output`."""
    def predict(self, table: _Frame, output: _Path | None = None, *, replace: bool = False) -> Table:
        """Predict rows that were not run; as `decore predict`.

        table: a mapping of values, a frame of pandas, polars or Arrow, a `Table`, rows as mappings, or an array of NumPy. Columns
        are taken by the names of the factors, `factor_` before them or not; numbers without names in the order of the factors.
        output: write the predictions to this Parquet file too.
        replace: replace an existing file.

        Warns by `PredictionWarning` of rows that are extrapolated (column `extrapolated`) and of models that are poor.
        """
    @property
    def warnings(self) -> list[str]:
        """Warnings, a sentence each."""
    @property
    def json(self) -> str:
        """The models' figures as JSON (schemas/surrogate.schema.json)."""
    @property
    def text(self) -> str:
        """In words, as `decore surrogate` prints it."""

@final
class Study:
    """A study, checked against its machine. The machine is reduced when the first row runs."""

    def __new__(
        cls,
        path: _Path,
        overrides: Mapping[str, _Setting] | None = None,
        *,
        retries: int = ...,
    ) -> Study:
        """Reads a study file. You can override values by their paths: `{"hammer.left.supply_bar": 4.5}`.

        Raises `StudyError` with all faults, `MachineError` where the machine's files cannot be read. `retries`: times a row that
        diverged is run again (1 unless given), each with a hundredth of the tolerance before.
        """
    @property
    def title(self) -> str:
        """Title of the study."""
    @property
    def hash(self) -> str:
        """Hash of everything that determines its rows."""
    @property
    def path(self) -> Path:
        """The study's file."""
    @property
    def overrides(self) -> list[str]:
        """Overrides of the study, `path=value`."""
    @property
    def retries(self) -> int:
        """Number of retries of a row that diverges."""
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
    def _repr_html_(self) -> str: ...
    def rows(self) -> Table:
        """The design: a row per run, a column per factor. Nothing is run."""
    def scene(
        self,
        row: SupportsIndex | _HasKeys | None = None,
        *,
        signals: bool | Sequence[str] | None = None,
        signal_interval_s: float = 1e-4,
    ) -> Row:
        """Simulates a row of the design (the first unless given), or one with these values of all factors, by their names.

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
        /,
        output: _Path | None = None,
        *,
        threads: int = 0,
        replace: bool = False,
        only_failed: bool = False,
        rows: str | Sequence[int] | None = None,
        rank_by: str = "strike_energy_j",
        shard: str | None = None,
        max_failed: int | None = None,
        summary: _Path | None = None,
        progress: bool | Callable[[Progress], object] | None = None,
    ) -> Dataset:
        """Run all rows of a study and write its tables."""
    def check(
        self,
        /,
        *,
        threads: int = 0,
        scatter: _Path | None = None,
        replace: bool = False,
        wanted_error: float = 0.01,
        strict: bool = False,
    ) -> Result:
        """Validate a study; print its size, the machine's modes, and the time it will take."""
    def design(
        self,
        /,
        output: _Path,
        *,
        replace: bool = False,
    ) -> Result:
        """Write the rows of a study's design to a file, without running them."""
    def structure(
        self,
        /,
        *,
        effects: bool = False,
        html: _Path | None = None,
        measured: _Path | None = None,
        damping_to: _Path | None = None,
        export: str | None = None,
        to: _Path | None = None,
        replace: bool = False,
    ) -> Result:
        """Compare a machine's reduction with its full model: frequencies, shapes, statics, mobilities, time and memory."""
    def accuracy(
        self,
        /,
        output: _Path | None = None,
        *,
        row: int = 0,
        replace: bool = False,
        repeats: int = 3,
        full_cutoff_hz: float = 1000000000,
        no_truncation: bool = False,
        quick: bool = False,
    ) -> Result:
        """Measure speed against error on one row of a study."""
    def refine(
        self,
        /,
        output: _Path | None = None,
        *,
        most_rows: int,
        learn: str | Sequence[str] = (),
        maximise: str | None = None,
        minimise: str | None = None,
        boundary: str | None = None,
        failures: bool = False,
        goal: bool = False,
        limits: str | Sequence[str] = (),
        until_q2: float = 0.95,
        until_width: Mapping[str, float] | Sequence[str] = (),
        until_gain: float | None = None,
        until_unsure: float = 0.01,
        batch: int = 4,
        progress: bool | Callable[[Progress], object] | None = None,
    ) -> Result:
        """Run a table of rows, and add those that teach or promise the most, batch by batch."""
    def best(
        self,
        /,
        output: _Path | None = None,
        *,
        rows: int = 160,
        checks: int = 100,
        batch: int = 12,
        progress: bool | Callable[[Progress], object] | None = None,
    ) -> Result:
        """Find the best values for the study's goal, and prove them by runs."""
    def write_scene(
        self,
        /,
        *,
        row: int = 0,
        signals: _Path | None = None,
        plot: _Path | None = None,
        html: _Path | None = None,
        replace: bool = False,
        signal_interval_s: float = 0.0001,
        measured: _Path | None = None,
        channels: Sequence[str] = (),
        time_column: str = "time_s",
        offset_s: float | None = None,
        low_pass_hz: float = 4000,
    ) -> Result:
        """Simulate one row of a study and print all its outputs."""
    def slurm(
        self,
        /,
        output: _Path | None = None,
        *,
        tasks: int,
        threads: int = 1,
        max_failed: int | None = None,
        options: Sequence[str] = (),
        submit: bool = False,
    ) -> Result:
        """Write, and on request submit, a Slurm job array for a sweep and the job that merges its shards."""
    def hyperqueue(
        self,
        /,
        output: _Path | None = None,
        *,
        tasks: int,
        threads: int = 1,
        max_failed: int | None = None,
    ) -> Result:
        """Write a Python script that runs a sweep and its merge on HyperQueue."""

def open(dataset: _Path) -> Dataset:
    """Opens the dataset in a folder."""

def merge(
    shards: Sequence[_Path | Dataset],
    output: _Path,
    *,
    replace: bool = False,
) -> Dataset:
    """Make one dataset of the shards of a sweep."""
def paper(
    *,
    html: _Path | None = None,
    replace: bool = False,
) -> Result:
    """Set the publication that the model follows beside what decore gives for its rig: figures, differences, why."""
def init(
    file: _Path = "study.toml",
    *,
    casting_mass_kg: float | None = None,
    casting_size_m: str | None = None,
    hammers: int | None = None,
    pressure_bar: float | None = None,
    limit_m_s: float | None = None,
    replace: bool = False,
) -> Result:
    """Write a commented study to start from."""

_Argument: TypeAlias = tuple[str, str | None, Literal["flag", "one", "many"], str | None, bool, str]

def _commands() -> list[tuple[str, str, list[_Argument]]]: ...
def _call(words: Sequence[str], progress: object = None) -> tuple[int, str, str, list[str], Path | None, Table | None]: ...
