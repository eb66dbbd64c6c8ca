"""Pneumatic de-coring hammers, castings and the machine below them: studies, sweeps and their tables.

    import decore

    study = decore.Study("studies/placement.toml", {"hammer.hammer.supply_bar": 4.5})
    row = study.scene(3, signals=True)
    dataset = study.run("out/placement", progress=True)

Every table implements the Arrow stream protocol: ``pyarrow.table(dataset.runs)``, ``polars.DataFrame(dataset.runs)``,
``pandas.DataFrame.from_arrow(dataset.runs)``, and in DuckDB a table by the name of its variable.
"""

from decore._decore import (
    Analysis,
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
