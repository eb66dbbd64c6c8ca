"""Holds what the commands print with `--json` to the schemas: every key must be declared, and every declared one be there.

Usage: python printed_json.py ROOT PROGRAM (the folder with `schemas` and `studies`; the built program)
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile

import jsonschema
import pyarrow.parquet

SWEEP = """
title = "small <sweep>"
duration_s = 0.25
[structure]
source = "station"
[outputs]
twins = 1
core_spectra = true
core_dose_reference_m_s = 1.0
core_wanted_dose = 1e9
[design]
kind = "latin_hypercube"
rows = 30
seed = 7
[design.factor.pressure]
path = "hammer.left.supply_bar"
range = [5.0, 6.5]
[design.factor.standoff]
path = "hammer.left.standoff_m"
range = [0.08, 0.09]
[hammer.left]
mount = "R5"
[casting.part]
mass_kg = 0.517
[casting.part.core.middle]
at_m = [0.0, 0.0, 0.0]
[casting.part.fixture.table]
point = "T5"
stiffness_n_per_m = 3e7
"""


GOAL = ["--set", "goal.maximise=strike_energy_j", "--set", "goal.limits=['max_first_impact_peak_force_n>=1']"]


def closed(schema):
    """The schema with objects that have no other keys than those that are declared."""
    if isinstance(schema, list):
        return [closed(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    made = {key: closed(value) for key, value in schema.items()}
    if isinstance(schema.get("properties"), dict) and schema.get("type") == "object":
        made.setdefault("additionalProperties", False)
    return made


def printed(program, folder, arguments, codes):
    """The JSON that a command prints."""
    done = subprocess.run([program, *arguments, "--json"], cwd=folder, capture_output=True, text=True)
    if done.returncode not in codes:
        sys.exit(f"printed_json: {arguments}: code {done.returncode}\n{done.stderr}")
    return json.loads(done.stdout)


def commands_with_json(program):
    """The commands whose help names `--json`."""
    def shown(*arguments):
        return subprocess.run([program, *arguments, "--help"], capture_output=True, text=True, check=True).stdout

    listed = shown().partition("Usage:")[2].partition("\nOptions:")[0].splitlines()
    names = [line.split()[0] for line in listed if line.startswith("  ") and line[2] != " "]
    if len(names) < 20:
        sys.exit(f"printed_json: only {names} are listed as commands")
    return {name for name in names if " --json" in shown(name)}


def sizes_are_right(folder, written):
    """Holds what a command says of its files to the files."""
    if not written["files"]:
        sys.exit("printed_json: no file is said to be written")
    for file in written["files"]:
        path = folder / file["path"]
        if path.stat().st_size != file["bytes"]:
            sys.exit(f"printed_json: {file}: it has {path.stat().st_size} bytes")
        rows = None
        if path.suffix == ".parquet":
            rows = pyarrow.parquet.read_metadata(path).num_rows
        elif file["kind"] == "design":
            rows = len(path.read_text().splitlines()) - 1
        if file["rows"] != rows:
            sys.exit(f"printed_json: {file}: it has {rows} rows")


def main(root, program):
    """All commands; the first fault ends the program."""
    schemas = {
        path.name.removesuffix(".schema.json"): json.loads(path.read_text())
        for path in sorted((root / "schemas").glob("*.schema.json"))
    }
    inputs = {"study", "hammer"}
    commands = [
        ("check", ["check", "sweep.toml"], [0]),
        ("check", ["check", str(root / "studies/three_hammers.toml")], [0]),
        ("check", ["check", "fraction.toml"], [0]),
        ("check", ["check", "single.toml"], [0]),
        ("report", ["run", "sweep.toml", "--output", "a"], [0]),
        ("report", ["run", "sweep.toml", "--output", "s1", "--shard", "1/2"], [0]),
        ("report", ["run", "sweep.toml", "--output", "s2", "--shard", "2/2"], [0]),
        ("report", ["merge", "s1", "s2", "--output", "b"], [0]),
        ("report", ["report", "a"], [0]),
        ("status", ["status", "a", "b"], [0]),
        ("verification", ["verify", "a", "b"], [0]),
        ("comparison", ["compare", "a", "b"], [0]),
        ("scene", ["scene", "sweep.toml", "--row", "3"], [0]),
        ("scene", ["scene", "a", "--row", "3"], [0]),
        ("scene", ["scene", "sweep.toml", "--measured", "arm.csv", "--channel", "left_arm_velocity_m_s=arm:mm/s"], [0]),
        ("scene", ["scene", "sweep.toml", "--set", "solver.max_steps=10"], [4]),
        ("paper", ["paper"], [0]),
        ("cores", ["cores", "a", "--tests", "tests.csv"], [0]),
        ("sensitivity", ["analyse", "a"], [0]),
        ("surrogate", ["surrogate", "a"], [0]),
        ("refinement", ["refine", "table.toml", "--maximise", "delivered_work_j", "--most-rows", "12"], [0]),
        ("refinement", ["refine", "table.toml", "--boundary", "delivered_work_j<=50", "--most-rows", "12"], [0]),
        ("best", ["refine", "table.toml", "--goal", "--most-rows", "12", *GOAL], [0]),
        ("refinement", ["refine", "table.toml", "--failures", "--until-unsure", "0.2", "--most-rows", "60"], [0]),
        ("best", ["best", "a", "--rows", "24", "--checks", "10", *GOAL], [0]),
        ("structure", ["structure", "sweep.toml", "--effects"], [0]),
        ("mobility", ["structure", "sweep.toml", "--measured", "measured.csv"], [0]),
        ("accuracy", ["accuracy", "sweep.toml", "--repeats", "1", "--quick", "--set", "duration_s=0.04"], [0]),
        ("written", ["design", "sweep.toml", "--output", "design.csv"], [0]),
        ("surrogate", ["surrogate", "a", "--output", "models.parquet"], [0]),
        ("written", ["predict", "models.parquet", "design.csv", "--output", "predicted.parquet"], [0]),
        ("written", ["export", "a", "--features", "features", "--splits", "0.7,0.3"], [0]),
        ("written", ["init", "new.toml"], [0]),
        ("written", ["man", "--output", "man"], [0]),
        ("written", ["slurm", "sweep.toml", "--tasks", "2", "--output", "s"], [0]),
        ("written", ["hyperqueue", "sweep.toml", "--tasks", "2", "--output", "h"], [0]),
        ("written", ["structure", "sweep.toml", "--export", "matrix_market", "--to", "matrices"], [0]),
        ("written", ["report", "a", "--html", "page.html"], [0]),
    ]
    with_json = commands_with_json(program)
    if missing := with_json - {arguments[0] for _, arguments, _ in commands}:
        sys.exit(f"printed_json: {sorted(missing)} have --json and no line here")
    if missing := set(schemas) - inputs - {name for name, _, _ in commands}:
        sys.exit(f"printed_json: no command prints {sorted(missing)}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        (folder / "sweep.toml").write_text(SWEEP)
        samples = [f"{k / 5000},{30 * math.sin(0.05 * k)}" for k in range(1250)]
        (folder / "arm.csv").write_text("\n".join(["time_s,arm", *samples]))
        (folder / "tests.csv").write_text("row,core_out_after_s\n0,30\n3,45\n5,60\n7,38\n")
        (folder / "matrices").mkdir()
        single = SWEEP[: SWEEP.index("[design]")] + SWEEP[SWEEP.index("[hammer.left]") :]
        (folder / "single.toml").write_text(single)
        gate = '[design.factor.gate]\npath = "hammer.left.gate_delay_s"\nrange = [0.01, 0.02]\n[hammer.left]'
        fraction = SWEEP.replace('"latin_hypercube"\nrows = 30\nseed = 7', '"fractional_factorial"\nresolution = 3')
        fraction = fraction.replace("[hammer.left]", gate)
        (folder / "fraction.toml").write_text(fraction)
        # A resonance at 200 Hz, measured at the mount.
        receptance = [1 / (200**2 - f**2 + 8j * f) for f in range(100, 301)]
        response = [f"R5.z,R5.z,{f},{r.real},{r.imag}" for f, r in zip(range(100, 301), receptance)]
        (folder / "measured.csv").write_text("\n".join(["response,force,frequency_hz,receptance_re,receptance_im", *response]))
        (folder / "table.toml").write_text(SWEEP.replace('"latin_hypercube"\nrows = 30', '"table"\nfile = "rows.csv"'))
        design = [program, "design", "sweep.toml", "--set", "design.rows=12", "--output", "rows.csv"]
        subprocess.run(design, cwd=folder, check=True, capture_output=True)
        for name, arguments, codes in commands:
            schema = closed(schemas[name])
            jsonschema.Draft202012Validator.check_schema(schema)
            said = printed(program, folder, arguments, codes)
            faults = list(jsonschema.Draft202012Validator(schema).iter_errors(said))
            if faults:
                sys.exit("\n".join([f"printed_json: {arguments}:"] + [f"{f.json_path}: {f.message[:300]}" for f in faults[:8]]))
            if name == "written":
                sizes_are_right(folder, said)
            print(f"printed_json: {' '.join(arguments[:2])} holds to {name}")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve())
