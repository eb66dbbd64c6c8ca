"""Checks the package as it is installed: bytes of a sweep, errors, tables, functions, interrupts, threads, time of a call.

Usage: python package.py PROGRAM STUDIES, with the program `decore` and the folder of the shipped studies. LIMIT_FACTOR loosens times, for
machines that do other work at the same time.
"""

import concurrent.futures
import multiprocessing
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import warnings

import duckdb
import numpy
import pandas
import polars
import pyarrow
import pyarrow.parquet

import decore

PROGRAM, STUDIES = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
PLACEMENT, GRID = STUDIES / "placement.toml", STUDIES / "pressure_grid.toml"
SHORT = {"duration_s": 0.15}
FACTOR = float(os.environ.get("LIMIT_FACTOR", "1"))
# Allowed over the simulation itself, for one call, in s.
MOST_OVERHEAD_S = 1e-3 * FACTOR
# Time from Ctrl-C to the exception, in s.
MOST_INTERRUPT_S = 0.5 * FACTOR
# Share of its rate that a Python thread keeps beside a sweep on another core.
LEAST_RATE = 0.9 / FACTOR
# Longest time for which a call may hold up a Python thread, in s.
MOST_GAP_S = 0.06 * FACTOR


def check(condition, message):
    """Unlike `assert`, also checks under `python -O`."""
    if not condition:
        sys.exit(f"package: {message}")


def raised(kind, call):
    """The exception of a call that must fail."""
    try:
        call()
    except kind as error:
        return error
    sys.exit(f"package: no {kind.__name__}")


def check_bytes(scratch):
    """A sweep is that of the command line, whatever the threads."""
    command = [PROGRAM, "run", GRID, "--set", "duration_s=0.15", "--set", "hammer.hammer.supply_bar=4.5", "--output"]
    subprocess.run([*command, scratch / "command"], check=True, capture_output=True)
    study = decore.Study(GRID, SHORT | {"hammer.hammer.supply_bar": 4.5})
    told = []
    dataset = study.run(scratch / "python", threads=2, progress=told.append)
    check((dataset.rows, dataset.rows_done, dataset.rows_failed) == (8, 8, 0), "the rows of the grid")
    check(told[-1].ended and told[-1].done == 8, f"progress ends with all rows: {told}")
    for name in ["manifest.json", "runs/runs-000000000000.parquet", "blows/blows-000000000000.parquet"]:
        same = (scratch / "command" / name).read_bytes() == (scratch / "python" / name).read_bytes()
        check(same, f"{name} is not that of the command line")
    again = study.run(scratch / "python", progress=told.append)
    check(told[-1].done == 8 and len(again.runs) == 8, "a sweep that is whole stays so")
    raised(decore.DatasetError, lambda: decore.Study(GRID).run(scratch / "python"))
    return dataset


def check_readers(dataset):
    """All readers see the same, units included."""
    for table in [dataset.runs, dataset.blows, dataset.timings]:
        arrow = pyarrow.table(table)
        columns = {"polars": polars.DataFrame(table), "pandas": pandas.DataFrame.from_arrow(table)}
        stream = table
        duck = duckdb.sql("select * from stream")
        for column in table.columns:
            field = arrow.schema.field(column.name)
            check(field.metadata[b"unit"].decode() == column.unit and column.description, f"unit of {column.name}")
            own = table[column.name]
            check(arrow[column.name].to_pylist() == own, f"{column.name} in pyarrow")
            check(columns["polars"][column.name].to_list() == own, f"{column.name} in polars")
            check([row[0] for row in duck.select(f'"{column.name}"').fetchall()] == own, f"{column.name} in DuckDB")
            seen = [None if pandas.isna(value) else value for value in columns["pandas"][column.name].tolist()]
            check(seen == own, f"{column.name} in pandas")
        check(len(table) == arrow.num_rows > 0, f"rows of {table}")
    check("did you mean" in str(raised(KeyError, lambda: dataset.runs["delivered_wrk_j"])), "the nearest column")
    check(dataset.runs.keys() == [column.name for column in dataset.runs.columns], "a table has keys")
    check([row["row"] for row in dataset.runs] == dataset.runs["row"], "a table goes over its rows")
    check("row" in dataset.runs and "rows" not in dataset.runs and 0 not in dataset.runs, "a table has its columns")


def check_signals(scratch, dataset):
    """The table of signals is there where the study asks for it, and as readable as the others."""
    check(dataset.signals is None, "a study without signals has no table of them")
    keeps = {"outputs.signals": ["part_heave_velocity_m_s"], "outputs.signal_rows": [2, 5]}
    kept = decore.Study(GRID, SHORT | keeps).run(scratch / "signals").signals
    check([column.name for column in kept.columns] == ["row", "time_s", "part_heave_velocity_m_s"], "columns of signals")
    check(set(kept["row"]) == {2, 5} and [column.unit for column in kept.columns] == ["1", "s", "m/s"], "rows of signals")
    arrow = pyarrow.table(kept)
    field = arrow.schema.field("part_heave_velocity_m_s")
    check(b"mean over 0.001 s" in field.metadata[b"description"], "the filter is not stated")
    check(any(arrow["part_heave_velocity_m_s"].to_pylist()), "the casting does not move")


def check_rows(dataset):
    """The rows of a design by index, by values, and as a function, are those of the sweep."""
    study = decore.Study(GRID, SHORT | {"hammer.hammer.supply_bar": 4.5})
    design = study.rows()
    check(design["factor_mount"] == dataset.runs["factor_mount"] and len(design) == len(study) == 8, "the design")
    work = dataset.runs["delivered_work_j"]
    row = study.scene(5, signals=["hammer_casting_force_n", "time_s"], signal_interval_s=1e-3)
    check(row.status == "done" and row["delivered_work_j"] == work[5], "row 5 by its index")
    check([column.name for column in row.signals.columns] == ["time_s", "hammer_casting_force_n"], "signals by name")
    check(len(row.signals) == 151 and len(study.scene(5, signals=True).signals.columns) > 20, "signals")
    blows = zip(dataset.blows["row"], dataset.blows["work_j"])
    check(row.blows["work_j"] == [work for row, work in blows if row == 5], "blows")
    values = {name: design[f"factor_{name}"][5] for name in ["mount", "standoff"]}
    check(study.scene(values)["delivered_work_j"] == work[5], "row 5 by its values")
    function = study.function("delivered_work_j", fixed={"mount": values["mount"]})
    check(function.factors == ["standoff"] and function.bounds == [(0.06, 0.085)], "what is left of the factors")
    rows = [index for index in range(8) if design["factor_mount"][index] == values["mount"]]
    found = function(numpy.array([[design["factor_standoff"][index]] for index in rows]))
    check(found.tolist() == [work[index] for index in rows], "the function's values are the sweep's")
    both = study.function(["delivered_work_j", "total_air_used_nl"], fixed=values)(numpy.empty((2, 0)))
    check(both.shape == (2, 2) and (both[0] == both[1]).all(), "outputs are columns")


def check_functions():
    """Shapes of arrays, points that cannot be, faults."""
    study = decore.Study(PLACEMENT, SHORT)
    work = study.function("delivered_work_j", factors=["position", "pressure"], fixed={"standoff": 0.08, "fixture_stiffness": 3e7})
    one, many = work([0.0, 5.0]), work([[0.0, 5.0], [2.0, 5.0], [0.01, 4]])
    check(isinstance(one, float) and many.shape == (3,) and many[0] == one, "one point and many")
    check(numpy.isnan(many[1]) and not numpy.isnan(many[2]), "a hammer beside its casting is no number")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        work([[0.0, 5.0], [0.12, 4.0]])
        check(not told, f"points in the ranges need no word: {[str(one.message) for one in told]}")
        work([[0.0, 6.5], [0.0, 5.0]])
    words = [str(one.message) for one in told if one.category is decore.StudyWarning]
    check(len(words) == 1 and "`pressure` outside its range in the design, 4 to 6" in words[0], f"a point outside: {words}")
    check(work(numpy.asfortranarray([[0.0, 5.0], [0.01, 4.0]]))[1] == many[2], "columns in Fortran's order")
    check(study.function(["delivered_work_j"])([[0.0, 5, 0.08, 3e7]]).shape == (1, 1), "a list of outputs is an axis")
    check("(points, 2)" in str(raised(ValueError, lambda: work([1.0, 2.0, 3.0]))), "the shape that was expected")
    found = work([[0.0, float("nan")], [0.0, 5.0], [float("inf"), 5.0]])
    check(numpy.isnan(found).tolist() == [True, False, True] and found[1] == one, f"no number is no point: {found}")
    masked = numpy.ma.array([[0.0, 5.0], [0.0, 4.0]])
    masked[1, 1] = numpy.ma.masked
    check(numpy.isnan(work(masked)).tolist() == [False, True] and numpy.isnan(work([0.0, float("nan")])), "nor is what is masked")
    check("did you mean" in str(raised(decore.DatasetError, lambda: study.function("delivered_wrk_j"))), "a near output")
    raised(decore.DatasetError, lambda: study.function("status"))
    rest = {"standoff": 0.08, "fixture_stiffness": 3e7}
    for words, factors, fixed in [
        ("no factor of the design", ["position", "presure"], rest),
        ("no factor of the design", None, {"presure": 5.0}),
        ("has no value", ["position"], rest),
        ("is NaN", ["position", "pressure"], rest | {"standoff": float("nan")}),
    ]:
        said = raised(decore.StudyError, lambda: study.function("delivered_work_j", factors=factors, fixed=fixed))
        check(words in str(said) and said.problems, f"{factors}, {fixed}: {said}")
    grid = decore.Study(GRID, SHORT)
    for words, call in [
        ("is in `factors` twice", lambda: study.function("delivered_work_j", factors=["position"] * 2)),
        ("in `factors` and in `fixed`", lambda: study.function("delivered_work_j", factors=["position"], fixed={"position": 0.0})),
        ("is given twice", lambda: study.function(["delivered_work_j"] * 2)),
        ("takes texts (R3 | R5)", lambda: grid.function("delivered_work_j")),
    ]:
        said = str(raised(ValueError, call))
        check(words in said, said)


def check_surrogate(scratch):
    """Models and predictions are those of the command line."""
    settings = SHORT | {"design.rows": 24}
    dataset = decore.Study(PLACEMENT, settings).run(scratch / "models", progress=None)
    models = dataset.surrogate(["delivered_work_j"])
    models.save(scratch / "python.parquet")
    rows = {"position": [0.0, 0.02], "pressure": [5.0, 5.5], "standoff": numpy.array([0.08, 0.07]), "fixture_stiffness": (3e7, 2e7)}
    said = models.predict(rows)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        models.predict(rows | {"pressure": [5.0, 50.0]})
    told = [str(one.message) for one in caught if issubclass(one.category, decore.PredictionWarning)]
    check(any("1 of 2 rows lie outside" in one for one in told), f"an extrapolation is said: {told}")
    pandas.DataFrame(rows).to_csv(scratch / "rows.csv", index=False)
    command = [PROGRAM, "surrogate", scratch / "models", "--outputs", "delivered_work_j", "--output", scratch / "command.parquet"]
    subprocess.run(command, check=True, capture_output=True)
    command = [PROGRAM, "predict", scratch / "command.parquet", scratch / "rows.csv", "--output", scratch / "said.parquet"]
    subprocess.run(command, check=True, capture_output=True)
    check(pyarrow.table(said).equals(pyarrow.parquet.read_table(scratch / "said.parquet")), "predictions of the command line")
    read = decore.Surrogate(scratch / "command.parquet")
    check(str(read) == str(models) and read.predict(rows)["delivered_work_j"] == said["delivered_work_j"], "a file of models")
    file = scratch / "predictions.parquet"
    models.predict(rows, file)
    check("predictions.parquet exists" in str(raised(ValueError, lambda: models.predict(rows, file))), "an existing file")
    models.predict(rows, file, replace=True)
    check("did you mean `pressure`" in str(raised(KeyError, lambda: models.predict(rows | {"presure": [5.0]}))), "an unknown factor")
    check("missing: `position`" in str(raised(KeyError, lambda: models.predict({"pressure": [5.0]}))), "a factor without values")
    check("has 1 values" in str(raised(ValueError, lambda: models.predict(rows | {"pressure": [5.0]}))), "columns of two lengths")
    raised(decore.DatasetError, lambda: models.predict(rows | {"pressure": ["high", "low"]}))


def check_errors(scratch):
    """File, line, key and suggestion of a fault; warnings."""
    file = scratch / "wrong.toml"
    text = PLACEMENT.read_text()
    file.write_text(text.replace("mass_kg = 3.0", "mas_kg = 3.0").replace("hammers/", f"{STUDIES}/hammers/"))
    line = next(number for number, line in enumerate(file.read_text().splitlines(), 1) if "mas_kg" in line)
    problems = raised(decore.StudyError, lambda: decore.Study(file)).problems
    found = [(problem.file, problem.line, problem.key, problem.suggestion) for problem in problems]
    check((str(file), line, "casting.part.mas_kg", "mass_kg") in found, f"what is wrong: {found}")
    raised(decore.StudyError, lambda: decore.Study(scratch / "absent.toml"))
    check(issubclass(decore.StudyError, decore.Error) and issubclass(decore.SweepError, decore.Error), "one family")
    endless, table, deep = [], {}, []
    endless.append(endless)
    table["a"] = [table]
    for _ in range(5000):
        deep = [deep]
    for nested in [endless, table, deep]:
        said = raised(ValueError, lambda: decore.Study(PLACEMENT, {"title": nested}))
        check("`title`" in str(said) and "contains itself" in str(said), f"a value without an end: {said}")
    study = decore.Study(PLACEMENT, SHORT)
    missing = raised(decore.StudyError, lambda: study.scene({"presure": 5.0})).problems
    check(any(problem.suggestion == "pressure" for problem in missing), f"{missing}")
    for row in [240, -1, 2**70]:
        check(f"0 to 239, not {row}" in str(raised(IndexError, lambda: study.scene(row))), f"row {row}")
    for row in [True, numpy.True_, "3", 3.0]:
        raised(TypeError, lambda: study.scene(row))
    values = {"position": 0.0, "pressure": 5.0, "standoff": 0.08, "fixture_stiffness": 3e7}
    for truth in [True, numpy.True_]:
        raised(TypeError, lambda: study.scene(values | {"position": truth}))
    check("give each once" in str(raised(ValueError, lambda: study.scene(0, signals=["time_s"] * 2))), "a signal twice")
    begin = time.perf_counter()
    long = decore.Study(PLACEMENT, {"duration_s": 600.0})
    near = str(raised(decore.DatasetError, lambda: long.scene(0, signals=["hammer_casting_force"], signal_interval_s=1.0)))
    check("did you mean `hammer_casting_force_n`" in near and time.perf_counter() - begin < 10.0 * FACTOR, f"no such signal: {near}")
    check(len(decore.Study(os.fsencode(PLACEMENT), SHORT)) == 240, "a path of bytes")
    check("expected str, bytes or os.PathLike" in str(raised(TypeError, lambda: decore.open(3))), "no path")
    raised(decore.DatasetError, lambda: decore.open(scratch / "absent"))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        decore.Study(PLACEMENT, {"hammer.hammer.supply_bar": 40.0})
    check(any(issubclass(one.category, decore.StudyWarning) for one in caught), "40 bar are unlikely")


def failing(study):
    """The error of another study, raised in a process of its own."""
    return [study, decore.Study(PLACEMENT, {"hammer.hammer.suply_bar": 4.5})]


def check_processes(scratch):
    """Exceptions with their problems, and studies, go from process to process."""
    file = scratch / "handed_on.toml"
    file.write_text(GRID.read_text().replace("hammers/", f"{STUDIES}/hammers/"))
    study = decore.Study(file, SHORT, retries=2)
    with concurrent.futures.ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        error = raised(decore.StudyError, lambda: pool.submit(failing, study).result())
        check(error.problems[0].suggestion == "hammer.hammer.supply_bar" and error.problems[0].text in str(error), f"problems: {error}")
        rows = pool.submit(len, study).result()
        check(rows == len(study), f"a study in another process: {rows}")
    again = pickle.loads(pickle.dumps(study))
    check(again.hash == study.hash and again.scene(3)["delivered_work_j"] == study.scene(3)["delivered_work_j"], "the same study")
    handed = pickle.dumps(study)
    file.write_text(file.read_text().replace("mass_kg = 0.517", "mass_kg = 0.6"))
    check("changed since" in str(raised(decore.StudyError, lambda: pickle.loads(handed))), "another study in its place")


def check_interrupt(scratch):
    """Ctrl-C ends a sweep of long rows within half a second; the same sweep goes on from the rows that ended, to the same bytes."""
    study = decore.Study(PLACEMENT, {"duration_s": 4.0, "design.rows": 12})
    study.scene(0)
    begun = []

    def interrupt():
        begun.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Timer(1.0, interrupt).start()
    raised(KeyboardInterrupt, lambda: study.run(scratch / "interrupted", threads=1))
    took = time.perf_counter() - begun[0]
    print(f"  Ctrl-C: {took:.2f} s")
    check(took < MOST_INTERRUPT_S, f"Ctrl-C took {took:.2f} s")
    if "fork" in multiprocessing.get_all_start_methods():
        child = multiprocessing.get_context("fork").Process(target=decore.Study(GRID, SHORT).run, args=(scratch / "forked",))
        child.start()
        child.join(60.0 * FACTOR)
        code = child.exitcode
        child.kill()
        check(code == 0, f"a forked process waits for rows that it does not run: {code}")
    told = []
    check(study.run(scratch / "interrupted", progress=told.append).rows_done == 12, "the sweep goes on")
    check(told[0].done < 12, f"rows that ended are kept: {told[0]}")
    study.run(scratch / "whole")
    for name in ["manifest.json", "runs/runs-000000000000.parquet", "blows/blows-000000000000.parquet"]:
        same = (scratch / "interrupted" / name).read_bytes() == (scratch / "whole" / name).read_bytes()
        check(same, f"{name} is not that of a sweep without an interrupt")


def check_overhead():
    """A call takes at most a millisecond more than the simulation within; the least of many, as the machine has other work."""
    study = decore.Study(PLACEMENT, {"duration_s": 0.02})
    study.scene(0)
    over = []
    for _ in range(100):
        begin = time.perf_counter()
        row = study.scene(3)
        over.append(time.perf_counter() - begin - row.wall_time_s)
    least = min(over)
    print(f"  a call of scene beyond its simulation: {1e3 * least:.2f} ms")
    check(least < MOST_OVERHEAD_S, f"a call takes {1e3 * least:.2f} ms beyond its simulation")


def rate(seconds):
    """Rounds of arithmetic per second of the calling thread."""
    begin, rounds = time.perf_counter(), 0
    while time.perf_counter() - begin < seconds:
        sum(range(1000))
        rounds += 1
    return rounds / (time.perf_counter() - begin)


def check_rate(scratch):
    """A Python thread goes on while a sweep runs on another core. Of several tries the best counts: the machine has other work."""
    if len(os.sched_getaffinity(0)) < 2:
        return print("  a Python thread beside a sweep: not tried, there is one core")
    study = decore.Study(PLACEMENT, {"duration_s": 6.0, "design.rows": 1000})
    study.scene(0)
    shares = []
    for attempt in range(3):
        alone, beside = rate(1.0), []

        def measure():
            time.sleep(0.3)
            beside.append(rate(1.0))
            os.kill(os.getpid(), signal.SIGINT)

        thread = threading.Thread(target=measure)
        thread.start()
        raised(KeyboardInterrupt, lambda: study.run(scratch / f"beside-{attempt}", threads=1, progress=lambda _: None))
        thread.join()
        shares.append(beside[0] / alone)
        if shares[-1] >= LEAST_RATE:
            break
    print(f"  a Python thread beside a sweep: {', '.join(f'{100 * share:.0f} %' for share in shares)} of its rate")
    check(max(shares) >= LEAST_RATE, "a Python thread is held up by a sweep")


def longest_gap(call):
    """The longest time in s for which a Python thread that wants to run every millisecond could not, during a call."""
    gaps, over = [0.0], threading.Event()

    def measure():
        last = time.perf_counter()
        while not over.is_set():
            time.sleep(0.001)
            now = time.perf_counter()
            gaps[0], last = max(gaps[0], now - last), now

    thread = threading.Thread(target=measure)
    thread.start()
    begin = time.perf_counter()
    # Freeing what came back is Python's own work, and held up by nobody here.
    kept = call()
    took = time.perf_counter() - begin
    over.set()
    thread.join()
    del kept
    return gaps[0], took


def check_turns(scratch):
    """Long columns and many points leave other threads their turn. Of several tries the best counts: the machine has other work."""
    keeps = {"outputs.signals": ["hammer_casting_force_n"], "outputs.signal_interval_s": 1e-6, "design.rows": 16}
    signals = decore.Study(PLACEMENT, SHORT | keeps).run(scratch / "long").signals
    work = decore.Study(PLACEMENT, SHORT).function("delivered_work_j")
    nowhere = numpy.full((300_000, 4), numpy.nan)
    for what, call in [("a long column", lambda: signals["hammer_casting_force_n"]), ("many points", lambda: work(nowhere))]:
        gap, took = min(longest_gap(call) for _ in range(3))
        print(f"  {what} of {took:.2f} s: other threads wait {1e3 * gap:.0f} ms")
        check(gap < MOST_GAP_S, f"{what}: other threads wait {gap:.2f} s of {took:.2f} s")


def main():
    # Where this runs in the background of a script, Ctrl-C is ignored from the start.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with tempfile.TemporaryDirectory() as name:
        scratch = pathlib.Path(name)
        dataset = check_bytes(scratch)
        check_readers(dataset)
        check_signals(scratch, dataset)
        check_rows(dataset)
        check_functions()
        check_surrogate(scratch)
        check_errors(scratch)
        check_processes(scratch)
        check_overhead()
        check_interrupt(scratch)
        check_rate(scratch)
        check_turns(scratch)


if __name__ == "__main__":
    main()
