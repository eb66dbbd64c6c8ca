"""Pneumatic de-coring hammers, castings and the machine below them: studies, sweeps and their tables.

>>> import decore
>>> study = decore.Study("studies/placement.toml", {"duration_s": 0.3, "design.rows": 24})
>>> dataset = study.run("out/first")
>>> dataset.runs.to_pandas()[["factor_pressure", "delivered_work_j"]].shape
(24, 2)
>>> dataset.report(best=3).best[0].row in range(24)
True

`Study` simulates rows (`scene`), sweeps (`run`), functions over arrays (`function`), and finds the best values (`best`).
`Dataset` has the tables and what follows from them (`report`, `analyse`, `cores`, `surrogate`, `compare`, `export`, `verify`).
Every command of the command line is a method with the same names and defaults. `decore help python` has the guide.
"""

from decore._decore import (
    Column,
    Dataset,
    DatasetError,
    Error,
    Factor,
    Function,
    MachineError,
    PredictionWarning,
    Problem,
    Progress,
    Row,
    Study,
    StudyError,
    StudyWarning,
    Surrogate,
    SweepError,
    Table,
    __version__,
    open,
)
from decore._result import Record, Result
from decore._tables import attach as _attach_frames
from decore._verbs import attach as _attach_verbs

_attach_frames()
_attach_verbs()

from decore._decore import init, merge, paper  # noqa: E402  (functions that were just attached)

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
    "Record",
    "Result",
    "Row",
    "Study",
    "StudyError",
    "StudyWarning",
    "Surrogate",
    "SweepError",
    "Table",
    "__version__",
    "init",
    "merge",
    "open",
    "paper",
]
