"""The commands of the command line as methods: their names, defaults and help are the command line's own."""

import ast
import inspect
import json
import os
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from decore import _decore
from decore._result import Result


_EMPTY = inspect.Parameter.empty
_ARGUMENTS = {name: {argument[0]: argument[1:] for argument in own} for name, _, own in _decore._commands()}
_HELP = {name: text for name, text, _ in _decore._commands()}
# Commands that run rows show how far they are.
_RUN_ROWS = ("run", "best", "refine", "analyse")
# Arguments that a study gives itself, or that are for datasets alone.
_OF_STUDY = ("overrides", "retries", "files_in")
# Arguments that may be given by their place.
_BY_PLACE = ("output", "outputs", "features", "second", "shards", "file")

# Methods of a study and of a dataset with an example each; the study or the dataset is the first argument of the command.
STUDY = {
    "run": ">>> study.run('out/example').rows_done\n24",
    "check": ">>> study.check().rows\n24",
    "design": ">>> study.design('out/rows.csv').files[0].rows\n24",
    "structure": ">>> study.structure().exit_code\n0",
    "accuracy": ">>> study.accuracy(quick=True, repeats=1)  # doctest: +SKIP",
    "refine": ">>> study.refine(learn=['delivered_work_j'], most_rows=40)  # doctest: +SKIP",
    "best": ">>> study.best(rows=40, checks=20).verdict  # doctest: +SKIP\n'proven'",
    "scene": ">>> study.write_scene(row=3, plot='out/row.svg').outcome.status\n'done'",
    "slurm": ">>> study.slurm(tasks=4)  # doctest: +SKIP",
    "hyperqueue": ">>> study.hyperqueue(tasks=4)  # doctest: +SKIP",
}
DATASET = {
    "report": ">>> len(dataset.report(best=3).best)\n3",
    "status": ">>> dataset.status().status.state\n'complete'",
    "verify": ">>> dataset.verify().whole\nTrue",
    "analyse": ">>> analysis = dataset.analyse(['delivered_work_j'], bootstrap=0)\n>>> 'pressure' in analysis.table['factor']\nTrue",
    "compare": ">>> dataset.compare(dataset).matched\n24",
    "export": ">>> dataset.export('out/features', replace=True).files[0].kind\n'features'",
    "cores": ">>> dataset.cores(tests='tests.csv').next_core.value  # doctest: +SKIP",
    "scene": ">>> dataset.scene(row=2).row\n2",
    "best": ">>> dataset.best(rows=40, checks=20)  # doctest: +SKIP",
}
MODULE = {
    "merge": ">>> decore.merge(['out/shard-1', 'out/shard-2'], 'out/merged')  # doctest: +SKIP",
    "paper": ">>> decore.paper().calculations.agree  # doctest: +SKIP",
    "init": ">>> decore.init('out/new_study.toml').files[0].kind  # doctest: +SKIP\n'study'",
}


# `Study.scene` takes values of the factors too and gives tables.
OTHER_NAMES: dict[tuple[type, str], str] = {(_decore.Study, "scene"): "write_scene"}


def surrogate(
    self: _decore.Dataset,
    outputs: Sequence[str] = (),
    *,
    output: str | os.PathLike[str] | None = None,
    replace: bool = False,
    least_q2: float = 0.9,
) -> _decore.Surrogate:
    """Model the outputs, so that rows not run can be predicted, with intervals.

    The command `decore surrogate`, with its names and defaults.

    outputs: Columns of the table of runs. Default: delivered work, work of the first impacts, hit frequency, largest
    velocity of the castings, air.
    output: Write the models to this Parquet file, and predict.py, which predicts with NumPy, beside it.
    replace: Replace an existing file of models.
    least_q2: Q2 below which a model warns at every use, by `PredictionWarning`.

    >>> dataset.surrogate(["delivered_work_j"], least_q2=0.0)
    <decore.Surrogate (position, pressure, standoff, fixture_stiffness) -> (delivered_work_j), 24 rows>
    """
    names = [outputs] if isinstance(outputs, str) else list(outputs)
    if output is None:
        return self._fit(names, least_q2)
    options = {"dataset": self.folder, "outputs": names, "output": output, "replace": replace, "least_q2": least_q2}
    _call("surrogate", options, None)
    return _decore.Surrogate(output)._warned()


def attach() -> None:
    """Gives the classes their methods and the module its functions."""
    for owner, verbs in [(_decore.Study, STUDY), (_decore.Dataset, DATASET)]:
        for command, example in verbs.items():
            name = OTHER_NAMES.get((owner, command), command)
            setattr(owner, name, _verb(command, example, owner, name))
    setattr(_decore.Dataset, "surrogate", surrogate)
    for command, example in MODULE.items():
        setattr(_decore, command, _verb(command, example, None, command))


def _verb(command: str, example: str, owner: type | None, name: str) -> Callable[..., Any]:
    arguments = dict(_ARGUMENTS[command])
    first = next(iter(arguments)) if owner else None
    if first:
        del arguments[first]
    if owner is _decore.Study:
        arguments = {name: one for name, one in arguments.items() if name not in _OF_STUDY}
    names = sorted(arguments, key=lambda name: (name not in _BY_PLACE, not arguments[name][3]))
    parameters = [_parameter(name, arguments[name]) for name in names]
    if command in _RUN_ROWS:
        parameters.append(inspect.Parameter("progress", inspect.Parameter.KEYWORD_ONLY, default=None))
    this = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)] if owner else []
    signature = inspect.Signature([*this, *parameters])

    def method(*given: Any, **named: Any) -> Any:
        bound = signature.bind(*given, **named)
        bound.apply_defaults()
        options = bound.arguments
        progress = options.pop("progress", None)
        if owner:
            options |= _own(command, first or "", options.pop("self"))
        return _call(command, options, progress)

    method.__name__ = name
    method.__qualname__ = f"{owner.__name__}.{name}" if owner else name
    method.__module__ = "decore"
    method.__doc__ = _doc(command, {name: arguments[name] for name in names}, example)
    method.__signature__ = signature  # type: ignore[attr-defined]
    return method


def _own(command: str, first: str, owner: Any) -> dict[str, Any]:
    """The arguments that a study or a dataset stands for."""
    if isinstance(owner, _decore.Dataset):
        return {first: owner.folder}
    rebuild, origin = owner.__reduce__()
    rebuild(*origin)  # refuses files that were changed since the study was read
    own = {first: owner.path, "overrides": owner.overrides}
    return own | ({"retries": owner.retries} if "retries" in _ARGUMENTS[command] else {})


def _call(command: str, options: dict[str, Any], progress: Any) -> Any:
    words, places = [command, "--json"], []
    for name, value in options.items():
        option, kind, default, required, _ = _ARGUMENTS[command][name]
        if not required and value == _default(kind, default):
            continue  # some options are refused without others, given or not
        for word in _words(value, kind):
            if option is None:
                places.append(word)
            else:
                words.append(f"--{option}" if kind == "flag" else f"--{option}={word}")
    try:
        code, text_json, text, notes, dataset, table = _decore._call([*words, "--", *places], progress)
    except ValueError as error:
        raise ValueError(_plain(str(error))) from None
    if code == _TOO_MANY_FAILED:
        raise _decore.SweepError("\n".join(notes))
    return _decore.open(dataset) if dataset else Result(command, text_json, text, notes, code, table)


# Exit code of a sweep that more rows failed of than were allowed.
_TOO_MANY_FAILED = 6


def _words(value: Any, kind: str) -> list[str]:
    """A value as the command line takes it, a word each time that its option is given."""
    if value is None or value is False:
        return []
    if isinstance(value, Mapping):
        return [f"{key}={one if isinstance(one, str) else json.dumps(one)}" for key, one in value.items()]
    if isinstance(value, (str, bytes, os.PathLike)):
        return [os.fsdecode(value)]
    if hasattr(value, "__iter__"):
        words = [word for one in value for word in _words(one, kind)]
        return words if kind == "many" or not words else [",".join(words)]
    return [str(value)]


def _parameter(name: str, argument: Any) -> inspect.Parameter:
    _, kind, default, required, _ = argument
    by_place = inspect.Parameter.POSITIONAL_OR_KEYWORD if name in _BY_PLACE else inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(name, by_place, default=_EMPTY if required else _default(kind, default))


def _default(kind: str, text: str | None) -> Any:
    if kind == "flag":
        return False
    if text is None:
        return () if kind == "many" else None
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text


def _doc(command: str, arguments: dict[str, Any], example: str) -> str:
    lines = [_plain(_HELP[command]), "", f"The command `decore {command}`, with its names and defaults.", ""]
    lines += [f"{name}: {_plain(argument[-1])}" for name, argument in arguments.items()]
    if command in _RUN_ROWS:
        lines.append("progress: `True` shows it in the terminal or the notebook; a callable is called with a `Progress`.")
    return "\n".join([*lines, "", example])


def _plain(text: str) -> str:
    """A text of the command line with the names of Python."""
    return re.sub(r"--([a-z][a-z0-9-]*)", lambda found: found[1].replace("-", "_"), text)
