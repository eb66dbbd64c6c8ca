"""Train a predictor of de-coring on a sweep: sweep, table, grouped cross-validation, score compared with the label's own noise.

Usage: python train_predictor.py [PROGRAM] [FOLDER] (default: `decore` from PATH, a temporary folder)

Install the packages first: pip install numpy polars duckdb scikit-learn xgboost

The label replaces a laboratory measurement: the share of the core that is left. It is made up, as a function of the casting's work and frequency,
with measuring noise of a known size. So the best possible score is known.
"""

import pathlib
import subprocess
import sys
import tempfile

import duckdb
import numpy as np
import polars as pl
from sklearn.model_selection import GroupKFold, KFold, cross_val_predict
from xgboost import XGBRegressor

STUDY = pathlib.Path(__file__).with_name("predictor.toml")
NOISE = 0.02
SIMULATED = ["work_j", "first_impact_energy_j", "periodic_energy_mean_j", "hit_frequency_mean_hz", "peak_velocity_m_s"]


def made(program, folder):
    """Run the sweep and return its flat table, as a frame of the rows that are done."""
    dataset, features = folder / "rows", folder / "features"
    subprocess.run([program, "run", STUDY, "--output", dataset], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([program, "export", dataset, "--features", features, "--splits", "0.8,0.2", "--replace"], check=True)
    return dataset, pl.read_parquet(features / "features.parquet").filter(pl.col("status") == "done")


def label(table):
    """Return the share of the core that is left, measured with noise."""
    removed = 1.0 - np.exp(-(table["work_j"] / 90.0) * (table["hit_frequency_mean_hz"] / 22.0) ** 0.5)
    return (1.0 - removed).to_numpy() + np.random.default_rng(1).normal(0.0, NOISE, len(table))


def score(truth, predicted):
    """Return the root mean square error and the predicted share of the variance."""
    error = np.sqrt(np.mean((truth - predicted) ** 2))
    return error, 1.0 - error**2 / np.var(truth)


def compare(table):
    """Return the scores of two sets of inputs, with folds by group and at random."""
    truth, groups = label(table), table["group_id"].to_numpy()
    factors = [name for name in table.columns if name.startswith("factor_")]
    model = XGBRegressor(n_estimators=300, max_depth=3, learning_rate=0.05, subsample=0.8, random_state=0, n_jobs=1)
    best = 1.0 - NOISE**2 / np.var(truth)
    print(f"{len(table)} rows in {len(set(groups))} groups; noise of the label {NOISE:.4f}: R2 {best:.3f} at best")
    found = {}
    for title, inputs in (("factors", factors), ("simulated figures", SIMULATED)):
        rows = table.select(inputs).to_numpy()
        for folds, of in (("by group", GroupKFold(5)), ("at random", KFold(5, shuffle=True, random_state=0))):
            parts = list(of.split(rows, truth, groups if isinstance(of, GroupKFold) else None))
            found[title, folds] = score(truth, cross_val_predict(model, rows, truth, cv=parts))
            print(f"from {title:<18} folds {folds:<10} error {found[title, folds][0]:.4f}, R2 {found[title, folds][1]:.3f}")
    return found


def held_out(table):
    """Return the score on the test part of `--splits`."""
    truth = label(table)
    train, test = (table["split"].to_numpy() == part for part in ("train", "test"))
    rows = table.select(SIMULATED).to_numpy()
    model = XGBRegressor(n_estimators=300, max_depth=3, learning_rate=0.05, subsample=0.8, random_state=0, n_jobs=1)
    error, share = score(truth[test], model.fit(rows[train], truth[train]).predict(rows[test]))
    print(f"trained on {train.sum()} rows, tested on {test.sum()} of other groups: error {error:.4f}, R2 {share:.3f}")


def as_it_lies(dataset, table):
    """Check that Polars and DuckDB read the same figures from the dataset as from the table."""
    by_polars = pl.scan_parquet(dataset / "blows" / "*.parquet").filter(pl.col("kind") != "blank").group_by("row").agg(pl.col("energy_j").mean()).collect()
    by_duckdb = duckdb.sql(f"select row, avg(energy_j) from '{dataset}/blows/*.parquet' where kind <> 'blank' group by row").fetchall()
    exported = dict(table.select("row", "blow_energy_mean_j").iter_rows())
    largest = max(
        abs(mean / exported[row] - 1.0) for means in (by_polars.iter_rows(), by_duckdb) for row, mean in means if row in exported
    )
    print(f"mean energy of the blows by Polars, DuckDB and in the table: within {largest:.1e}")
    if largest > 1e-12:
        sys.exit("they differ")


def main(program, folder):
    """Run all steps in a folder."""
    dataset, table = made(program, folder)
    found = compare(table)
    held_out(table)
    as_it_lies(dataset, table)
    if found["simulated figures", "by group"][0] > 1.5 * NOISE:
        sys.exit("the predictor is far from the label's noise")


if __name__ == "__main__":
    program = sys.argv[1] if len(sys.argv) > 1 else "decore"
    if len(sys.argv) > 2:
        main(program, pathlib.Path(sys.argv[2]))
    else:
        with tempfile.TemporaryDirectory() as scratch:
            main(program, pathlib.Path(scratch))
