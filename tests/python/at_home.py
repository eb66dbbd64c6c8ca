"""Checks what a data scientist does in the first cells: frames, names, rows, commands as methods, pickles, notebooks, examples.

Usage: python at_home.py PROGRAM STUDIES, with the program `decore` and the folder of the shipped studies.
"""

import concurrent.futures
import doctest
import inspect
import multiprocessing
import os
import pathlib
import pickle
import re
import subprocess
import sys
import tempfile
import warnings

import duckdb
import nbclient
import nbformat
import numpy
import pandas
import scipy.optimize

import decore

PROGRAM, STUDIES = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
SETTINGS = {"duration_s": 0.3, "design.rows": 24}
# Commands whose result only people and shells read.
WITHOUT_METHOD = {"completions", "man", "help"}
# Options with several values have the plural in Python, where they are given once.
PLURALS = {"set": "overrides", "limit": "limits", "channel": "channels", "sbatch": "options"}
# Methods of other names or shapes, and why.
SELF = {"STUDY", "FILE", "DATASET", "DATASETS", "A"}
OF_STUDY = {"overrides", "retries", "files_in"}


def check(condition, message):
    """Unlike `assert`, also checks under `python -O`."""
    if not condition:
        sys.exit(f"at_home: {message}")


def raised(kind, call):
    """The exception of a call that must fail."""
    try:
        call()
    except kind as error:
        return error
    sys.exit(f"at_home: no {kind.__name__}")


def check_tables(dataset):
    """pandas reads tables in the first cell as `to_pandas` does; the others too, with units."""
    for table in [dataset.runs, dataset.blows]:
        frame, own = pandas.DataFrame(table), table.to_pandas()
        check(frame.shape == (len(table), len(table.columns)) and list(frame) == table.keys(), f"DataFrame({table}): {frame.shape}")
        pandas.testing.assert_frame_equal(frame, own, check_dtype=False)
        check(own.dtypes["row"] == "uint64" and own.attrs["units"] == table.units, "types and units")
        check(all(table.to_polars()[name].to_list() == table[name] for name in table.keys()), "polars")
        check(table.to_arrow().column_names == table.keys(), "Arrow's columns")
        check(table._repr_html_().count("<tr>") == min(len(table), 12) + 1, "the first rows as HTML")


def frames(table, factors):
    """The rows of a table in all forms that have names, and without names in the factors' order."""
    frame = table.to_pandas()
    shuffled = frame[list(frame)[::-1]]
    named = frame.rename(columns=lambda name: name.removeprefix("factor_"))
    structured = numpy.empty(len(frame), [(name, named[name].dtype) for name in named])
    for name in named:
        structured[name] = named[name]
    return {
        "table": table,
        "pandas": frame,
        "pandas, shuffled": shuffled,
        "pandas, names alone": named.drop(columns="row"),
        "polars, shuffled": table.to_polars().select(list(shuffled)),
        "Arrow": table.to_arrow(),
        "Arrow batch": table.to_arrow().to_batches()[0],
        "DuckDB": duckdb.sql("select * from shuffled"),
        "mapping": dict(table),
        "mapping of arrays": {name: named[name].to_numpy() for name in reversed(factors)},
        "rows": shuffled.to_dict("records"),
        "structured array": structured,
        "array": named[factors].to_numpy(),
        "lists": named[factors].to_numpy().tolist(),
    }


def check_names(study, models):
    """Names are obeyed by functions and models, whatever the frame; what is unknown, missing or there twice is refused."""
    factors = [factor.name for factor in study.factors]
    function = study.function("delivered_work_j")
    forms = frames(study.rows(), factors)
    works, said = function(forms["array"]), models.predict(forms["array"])["delivered_work_j"]
    for form, given in forms.items():
        check((function(given) == works).all(), f"the function of {form}")
        check(models.predict(given)["delivered_work_j"] == said, f"the prediction of {form}")
    frame = forms["pandas"]
    for call in [function, models.predict]:
        for words, wrong in [
            ("unknown: `presure`; did you mean `pressure`?; missing: `pressure`", frame.rename(columns={"factor_pressure": "factor_presure"})),
            ("missing: `pressure`", frame.drop(columns="factor_pressure")),
            ("unknown: `extra`", frame.assign(extra=1.0)),
            ("unknown: `0`, `1`, `2`, `3`", pandas.DataFrame(forms["array"])),
            ("given twice: `pressure`", frame.assign(pressure=5.0)),
            ("row 1 has other names", [{"pressure": 5.0}, {"position": 0.0}]),
        ]:
            found = str(raised(KeyError, lambda: call(wrong)))
            check(words in found, found)
    one = frame.iloc[3]
    check(function(one) == works[3] and function(dict(one)) == works[3], "a row of a frame is a point")
    check(study.scene(one)["delivered_work_j"] == works[3], "and a scene")
    check(models.predict(dict(one))["delivered_work_j"] == said[3:4], "and a place to predict")


def check_rows(study):
    row = study.scene(3)
    values = dict(row)
    check(len(values) == len(row) == len(row.runs.columns) and values == row.to_dict(), "dict(row)")
    check("status" in row and "statu" not in row and list(row) == row.keys(), "a row has names")
    check((study.scene().index, row.index, row.study.hash) == (0, 3, study.hash), "row 0 unless given")
    check("<svg" in row._repr_html_() and "delivered_work_j" in row._repr_html_(), "a row's picture in a notebook")


def options(command):
    """Names and defaults of a command by its help."""
    wide = os.environ | {"COLUMNS": "1000"}
    text = subprocess.run([PROGRAM, command, "-h"], check=True, capture_output=True, text=True, env=wide).stdout
    found = {}
    for line in text.splitlines():
        place = re.match(r"  [<\[]([A-Z]+)[>\]]", line)
        option = re.match(r"  (?:-\w, |    )--([a-z0-9-]+)(?: <|  |$)", line)
        default = re.search(r"\[default: (.*?)\]", line)
        if option and option[1] not in ("json", "help"):
            is_flag = not re.search(r"--" + option[1] + r" [<\[]", line)
            found[option[1].replace("-", "_")] = default[1] if default else "False" if is_flag else None
        elif place and place[1] not in SELF:
            found[{"B": "second", "SHARDS": "shards", "MODEL": "model", "TABLE": "table", "FILE": "file"}[place[1]]] = default and default[1]
        elif place and not found:
            found["self"] = default[1] if default else None
    return found


def check_commands():
    """Each command is a method with the same names and defaults. Both are listed."""
    text = subprocess.run([PROGRAM, "--help"], check=True, capture_output=True, text=True).stdout
    commands = re.findall(r"^  ([a-z]+)  ", text.split("Usage:")[1].split("Options:")[0], re.M)
    check(len(commands) > 20, f"{commands}")
    for command in sorted(set(commands) - WITHOUT_METHOD):
        owners = [owner for owner in (decore.Study, decore.Dataset, decore.Surrogate, decore) if hasattr(owner, command)]
        check(owners, f"no method `{command}`")
        line = {PLURALS.get(name, name): default for name, default in options(command).items()}
        own_place = line.pop("self", None)
        if command in ("compare", "analyse"):
            line["outputs"] = line.pop("output")
        for owner in owners:
            if (owner, command) == (decore.Study, "scene"):
                continue  # takes values of factors and returns tables: the command is `write_scene`
            compare_signature(owner, command, dict(line), own_place)
    compare_signature(decore.Study, "write_scene", {PLURALS.get(n, n): d for n, d in options("scene").items() if n != "self"}, None)


def compare_signature(owner, name, line, own_place):
    parameters = inspect.signature(getattr(owner, name)).parameters
    python = {one: value.default for one, value in parameters.items() if one not in ("self", "progress")}
    if owner is decore.Study:
        line = {one: default for one, default in line.items() if one not in OF_STUDY}
    if owner is decore.Surrogate:
        line.pop("model", None)
    if name == "init":
        line = {"file": own_place} | line
    shown = {one: None if value in (None, (), inspect.Parameter.empty) else str(value) for one, value in python.items()}
    numbers = {one: str(float(value)) if re.fullmatch(r"[0-9][0-9.e+-]*", value or "") else value for one, value in line.items()}
    alike = {one: str(float(value)) if re.fullmatch(r"[0-9][0-9.e+-]*", value or "") else value for one, value in shown.items()}
    print(f"  {owner.__name__}.{name}: {', '.join(f'{one}={value}' for one, value in shown.items())}")
    check(numbers == alike, f"`{name}`\n  command line {numbers}\n  Python       {alike}")


def check_results(study, dataset, scratch):
    """Results are those that the command line prints as JSON, as attributes, dicts, words and HTML."""
    for words, result in [
        (["report"], dataset.report()),
        (["report", "--rank-by=-delivered_work_j", "--best=2"], dataset.report(rank_by="-delivered_work_j", best=2)),
        (["verify"], dataset.verify()),
        (["analyse", "--output", "delivered_work_j", "--bootstrap", "100"], dataset.analyse(["delivered_work_j"], bootstrap=100)),
        (["scene", "--row", "2", "--files-in", "."], dataset.scene(row=2)),
        (["compare", "--relative=1e-3", dataset.folder], dataset.compare(dataset, relative=1e-3)),
    ]:
        command = [PROGRAM, words[0], dataset.folder, *words[1:], "--json"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        check(done.stdout.strip() == result.json.strip() or "wall_time_s" in done.stdout, f"{words}: {done.stdout[:500]} {result.json[:500]}")
        check(result.exit_code == done.returncode, f"{words} ends with {result.exit_code}, {done.returncode}")
        check(len(repr(result).splitlines()) <= 42 and result.text and len(result._repr_html_()) > 100, f"{words}: one screen")
        again = pickle.loads(pickle.dumps(result.to_dict()))
        check(again == result.to_dict() and set(again) <= set(dir(result)), f"{words}: attributes")
    check(dataset.analyse(["delivered_work_j"], bootstrap=0).table["factor"], "a table of indices")
    check(dataset.report().best[0].row in dataset.runs["row"], "attributes of attributes")
    check("no attribute `bst`" in str(raised(AttributeError, lambda: dataset.report().bst)), "an attribute that is not there")
    check("<pre" in dataset._repr_html_() and "pressure" in study._repr_html_(), "HTML of studies and datasets")
    check(study.design(scratch / "rows.csv").files[0].rows == 24, "a design file")
    again = study.run(scratch / "dataset", rows=[3, 5], threads=1)
    check(again.runs["delivered_work_j"] == dataset.runs["delivered_work_j"], "rows that were run again")
    check("invalid value" in str(raised(ValueError, lambda: study.best(batch=0))), "what the command line refuses")
    shards = [study.run(scratch / f"shard-{part}", shard=f"{part}/2") for part in (1, 2)]
    check(decore.merge(shards, scratch / "merged").runs["delivered_work_j"] == dataset.runs["delivered_work_j"], "merged shards")
    best = study.best(scratch / "best", rows=4, checks=2, batch=2)
    check(best.verdict and "verdict" in best.to_dict() and best.text, f"the best values: {best!r}")
    table = scratch / "refined.toml"
    text = (STUDIES / "placement.toml").read_text().replace("hammers/", f"{STUDIES}/hammers/")
    table.write_text(text.replace('kind = "latin_hypercube"\nrows = 240\nseed = 1', 'kind = "table"\nfile = "rows.csv"'))
    refined = decore.Study(table, {"duration_s": 0.3}).refine(scratch / "refined", learn="delivered_work_j", most_rows=30, batch=3)
    check(decore.open(scratch / "refined").rows_done == 30 and refined.text, f"refined: {refined!r}")
    raised(decore.SweepError, lambda: decore.Study(STUDIES / "placement.toml", SETTINGS | {"solver.max_steps": 10}).run(scratch / "fails", max_failed=0))


def check_models(dataset):
    """A model that predicts poorly warns when it is made, not only when it is used."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        models = dataset.surrogate(["delivered_work_j"])
    check(all(one.filename == __file__ for one in caught), f"warnings name the caller: {caught[0].filename}")
    words = [str(one.message) for one in caught if one.category is decore.PredictionWarning]
    check(any("Q2" in one for one in words) and words == models.warnings, f"a poor model warns: {words}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        models = dataset.surrogate(["delivered_work_j"], least_q2=0.0)
    check(repr(models) == "<decore.Surrogate (position, pressure, standoff, fixture_stiffness) -> (delivered_work_j), 24 rows>", repr(models))
    return models


def loss(x, work):
    """What an optimiser in several processes calls."""
    return -work(x)


def check_processes(study, dataset, models):
    """Studies, functions, datasets and models go to other processes, forked and spawned; SciPy and Optuna use several."""
    work = study.function("delivered_work_j", factors=["pressure", "standoff"], fixed={"position": 0.0, "fixture_stiffness": 3e7})
    points, rows = [[5.0, 0.08], [4.5, 0.07]], study.rows()
    works, said = work(points).tolist(), models.predict(rows)["delivered_work_j"]
    for method in {"fork", "spawn"} & set(multiprocessing.get_all_start_methods()):
        with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context(method)) as pool:
            found = pool.submit(work, points).result(120).tolist()
            check(found == works, f"{method}: {found}")
            check(list(pool.map(work, points, timeout=120)) == works, f"{method}: points")
            check(pool.submit(predicted, models, study).result(120) == said, f"{method}: models")
            check(pool.submit(len_of, dataset).result(120) == len(dataset.runs), f"{method}: a dataset")
    search = dict(bounds=work.bounds, popsize=4, maxiter=1, seed=1, polish=False, updating="deferred", args=(work,))
    alone = scipy.optimize.differential_evolution(loss, **search)
    several = scipy.optimize.differential_evolution(loss, workers=-1, **search)
    check(alone.fun == several.fun and (alone.x == several.x).all(), f"differential evolution: {alone.fun}, {several.fun}")
    direct = scipy.optimize.differential_evolution(work, work.bounds, popsize=4, maxiter=1, seed=1, polish=False, workers=-1, updating="deferred")
    check(direct.nfev == several.nfev, "a function by itself")


def check_notebook(scratch):
    """Progress is one line of a cell that is rewritten; objects have pictures and tables."""
    cells = [
        "import decore\nstudy = decore.Study('studies/placement.toml', {'duration_s': 0.3, 'design.rows': 120})",
        "dataset = study.run('out/notebook', progress=True)",
        "study.scene(3)",
        "dataset",
        "dataset.report()",
        "dataset.runs",
    ]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": scratch}}).execute()
    outputs = [cell.outputs for cell in notebook.cells]
    check(outputs[0] == [], f"nothing is told of a sound study: {outputs[0]}")
    lines = [output["data"]["text/plain"] for output in outputs[1]]
    check(len(lines) == 1 and lines[0].startswith("120 of 120 rows"), f"progress: {outputs[1]}")
    html = [output[0]["data"]["text/html"] for output in outputs[2:]]
    check("<svg" in html[0] and all("<table" in one or "<pre" in one for one in html), "HTML of objects")
    nbformat.write(notebook, scratch / "notebook.ipynb")


def predicted(models, study):
    return models.predict(study.rows())["delivered_work_j"]


def len_of(dataset):
    return len(dataset.runs)


def examples():
    """Callables of the package with their docstrings."""
    yield "decore", decore.__doc__
    for name in decore.__all__:
        one = getattr(decore, name)
        if inspect.isclass(one) and not issubclass(one, (Exception, decore.Record)):
            yield name, one.__doc__
            for part, method in vars(one).items():
                if callable(method) and not part.startswith("_"):
                    yield f"{name}.{part}", method.__doc__
        elif callable(one) and not inspect.isclass(one):
            yield name, one.__doc__


def check_examples(names, scratch):
    """Each docstring of a callable has an example, and each example is right."""
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    # Made by decore alone.
    others = {"Factor", "Column", "Problem", "Progress"}
    count, without = 0, []
    for name, text in examples():
        test = parser.get_doctest(text or "", dict(names), name, None, None)
        if not test.examples and name not in others:
            without.append(name)
        count += len(test.examples)
        runner.run(test)
    check(not without, f"no example: {', '.join(without)}")
    check(runner.summarize().failed == 0, "an example is not right")
    print(f"  {count} examples")


def main():
    with tempfile.TemporaryDirectory() as name:
        scratch = pathlib.Path(name)
        (scratch / "studies").symlink_to(STUDIES)
        (scratch / "out").mkdir()
        os.chdir(scratch)
        study = decore.Study("studies/placement.toml", SETTINGS)
        dataset = study.run(scratch / "dataset")
        models = check_models(dataset)
        check_tables(dataset)
        check_names(study, models)
        check_rows(study)
        check_commands()
        check_results(study, dataset, scratch)
        check_examples({"decore": decore, "study": study, "dataset": dataset, "models": models}, scratch)
        check_notebook(scratch)
        check_processes(study, dataset, models)


if __name__ == "__main__":
    main()
