# %% [markdown]
# # Optimise with Optuna and SciPy
#
# A study's function can be pickled, so optimisers use several processes. `study.best()` also confirms its answer with runs.

# %%
import concurrent.futures
import multiprocessing
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import optuna
import scipy.optimize
from optuna.storages.journal import JournalFileBackend

import decore

WORKERS = 4
TRIALS = 10
LOG = Path("out/optuna.log")
FIXED = {"standoff": 0.08, "fixture_stiffness": 3e7}


def load(log: Path) -> optuna.Study:
    """Open the search that all processes share, in a file."""
    storage = optuna.storages.JournalStorage(JournalFileBackend(str(log)))
    return optuna.create_study(study_name="work", storage=storage, direction="maximize", load_if_exists=True)


def search(work: decore.Function, log: Path, seed: int) -> int:
    """Run the trials of one process."""
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    bounds = dict(zip(work.factors, work.bounds))

    def objective(trial: optuna.Trial) -> float:
        return float(work({name: trial.suggest_float(name, *ends) for name, ends in bounds.items()}))

    shared = load(log)
    shared.sampler = optuna.samplers.TPESampler(seed=seed)
    shared.optimize(objective, n_trials=TRIALS)
    return TRIALS


def main() -> None:
    study = decore.Study("studies/placement.toml", {"duration_s": 0.3})
    work = study.function("delivered_work_j", factors=["position", "pressure"], fixed=FIXED)

    LOG.parent.mkdir(exist_ok=True)
    LOG.unlink(missing_ok=True)
    with concurrent.futures.ProcessPoolExecutor(WORKERS, multiprocessing.get_context("spawn")) as pool:
        list(pool.map(search, [work] * WORKERS, [LOG] * WORKERS, range(WORKERS)))
    found = load(LOG)
    print(f"Optuna: {found.best_value:.1f} J at {found.best_params}, {len(found.trials)} trials")

    low, high = zip(*work.bounds)
    bounds = scipy.optimize.Bounds(list(low), list(high))
    result = scipy.optimize.differential_evolution(
        negative, bounds, args=(work,), popsize=8, maxiter=4, rng=1, polish=False, workers=-1, updating="deferred"
    )
    print(f"SciPy: {-result.fun:.1f} J at {dict(zip(work.factors, result.x.tolist()))}, {result.nfev} calls")

    trials = found.trials_dataframe()
    plt.figure(figsize=(6, 4))
    points = plt.scatter(1e3 * trials["params_position"], trials["params_pressure"], c=trials["value"])
    plt.plot(1e3 * result.x[0], result.x[1], "r*", markersize=14, label="SciPy")
    plt.xlabel("position on the rail in mm")
    plt.ylabel("supply pressure in bar")
    plt.colorbar(points, label="delivered work in J")
    plt.legend()
    plt.tight_layout()
    plt.savefig("out/optimise.png")


def negative(x: np.ndarray[tuple[int], np.dtype[np.float64]], /, *given: decore.Function) -> float:
    """Return the negative work, because SciPy minimises."""
    return -float(given[0](x))


# %%
if __name__ == "__main__":
    main()
