"""How few rows can any design need? Maximin Latin hypercubes beside designs that are optimal for the true process.

    python benches/refinement_bound.py g 48,56,64,72,80,88,96
    python benches/refinement_bound.py FOLDER:COLUMN 8,12,16,20      (a dataset of decore and a column of its runs)

The truth is a function, or what a Gaussian process expects that was fitted to a dataset's rows. The optimal designs know what nobody
knows before the first run: the lengths of the true process. Their rows are those of 512 Sobol' points that leave the least integrated
variance, chosen one by one and then exchanged twice. Both designs' rows are fitted anew, and asked for 1000 other places; printed is
the median over the seeds of the share of the variance that is predicted. Needs NumPy and SciPy, and DuckDB for datasets.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys

import numpy
from scipy.optimize import minimize
from scipy.stats import qmc

SEEDS = 20
CANDIDATES = 512
LEAST_NOISE = 1e-6


def correlations(weights, some, others):
    """Matern 5/2 in each factor."""
    scaled = numpy.sqrt(5.0) * numpy.abs(some[:, None] - others[None]) * weights
    return numpy.prod((1.0 + scaled + scaled**2 / 3.0) * numpy.exp(-scaled), axis=2)


def fitted(points, values):
    """Weights and noise of the likeliest process with a constant mean, and what it expects."""
    rows, factors = points.shape
    mean, scale = values.mean(), values.std() + 1e-300
    values = (values - mean) / scale

    def solved(parameters):
        matrix = correlations(numpy.exp(parameters[:factors]), points, points) + numpy.exp(parameters[factors]) * numpy.eye(rows)
        lower = numpy.linalg.cholesky(matrix)
        one, right = (numpy.linalg.solve(lower, side) for side in (numpy.ones(rows), values))
        level = one @ right / (one @ one)
        return lower, right - level * one, level

    def unlikely(parameters):
        try:
            lower, left, _ = solved(parameters)
        except numpy.linalg.LinAlgError:
            return 1e9
        return 0.5 * rows * numpy.log(left @ left / rows) + numpy.log(numpy.diag(lower)).sum()

    bounds = [(-5.0, 3.5)] * factors + [(-14.0, 1.0)]
    starts = [numpy.r_[numpy.full(factors, numpy.log(weight)), -9.0] for weight in (1.0, 4.0)]
    found = [minimize(unlikely, start, method="L-BFGS-B", bounds=bounds, options={"maxiter": 60}) for start in starts]
    best = min(found, key=lambda one: one.fun).x
    lower, left, level = solved(best)
    shares = numpy.linalg.solve(lower.T, left)
    weights = numpy.exp(best[:factors])

    def expected(places):
        return mean + scale * (level + correlations(weights, places, points) @ shares)

    return weights, max(numpy.exp(best[factors]), LEAST_NOISE), expected


def optimal(prior, noise, rows):
    """The candidates that leave the least variance over all of them."""

    def unknown(known):
        if not known:
            return prior
        across = prior[:, known]
        return prior - across @ numpy.linalg.solve(prior[numpy.ix_(known, known)] + noise * numpy.eye(len(known)), across.T)

    def next_to(known):
        left = unknown(known)
        gains = (left**2).sum(axis=0) / (numpy.diag(left) + noise)
        gains[known] = -1.0
        return int(gains.argmax())

    chosen = []
    for _ in range(rows):
        chosen.append(next_to(chosen))
    for place in list(range(rows)) * 2:
        rest = chosen[:place] + chosen[place + 1 :]
        chosen = rest[:place] + [next_to(rest)] + rest[place:]
    return chosen


def maximin(rows, factors, random):
    """The one of 60 Latin hypercubes whose nearest points are the farthest."""
    designs = [qmc.LatinHypercube(factors, rng=random).random(rows) for _ in range(60)]

    def nearest(design):
        return (((design[:, None] - design[None]) ** 2).sum(axis=2) + 9.0 * numpy.eye(rows)).min()

    return max(designs, key=nearest)


def predicted(truth, points, places):
    """Share of the variance at the places that rows at the points predict."""
    values, expected = truth(places), fitted(points, truth(points))[2](places)
    return 1.0 - ((values - expected) ** 2).sum() / ((values - values.mean()) ** 2).sum()


def ishigami(points):
    a, b, c = (numpy.pi * (2.0 * points - 1.0)).T
    return numpy.sin(a) + 7.0 * numpy.sin(b) ** 2 + 0.1 * c**4 * numpy.sin(a)


def g(points):
    a = numpy.array([0.0, 1.0, 4.5, 9.0, 99.0, 99.0])
    return numpy.prod((numpy.abs(4.0 * points - 2.0) + a) / (1.0 + a), axis=1)


def of_dataset(folder, column):
    """What a process expects that was fitted to 700 rows of a dataset, its weights and noise."""
    import duckdb

    table = duckdb.sql(f"select * from '{folder}/runs/*.parquet' where status = 'done' order by row").fetchnumpy()
    names = [name for name in table if name.startswith("factor_")]
    points = numpy.column_stack([numpy.asarray(table[name], float) for name in names])
    wide = points.min(axis=0) > 0.0
    # What ranges over a factor of ten is taken by its logarithm, as the station's fixtures are.
    wide &= points.max(axis=0) >= 9.0 * points.min(axis=0)
    points[:, wide] = numpy.log(points[:, wide])
    points = (points - points.min(axis=0)) / (points.max(axis=0) - points.min(axis=0))
    weights, noise, expected = fitted(points[:700], numpy.asarray(table[column], float)[:700])
    return len(names), expected, weights, LEAST_NOISE


def main():
    case, sizes = sys.argv[1], [int(size) for size in sys.argv[2].split(",")]
    functions = {"ishigami": (3, ishigami), "g": (6, g)}
    if case in functions:
        factors, truth = functions[case]
        points = qmc.Sobol(factors, rng=numpy.random.default_rng(1)).random(512)
        weights, noise, _ = fitted(points, truth(points))
    else:
        factors, truth, weights, noise = of_dataset(*case.rsplit(":", 1))
    print(f"{case}: weights {weights.round(2)}")
    for rows in sizes:
        shares = []
        for seed in range(SEEDS):
            random = numpy.random.default_rng(seed)
            places = random.random((1000, factors))
            candidates = qmc.Sobol(factors, rng=random).random(CANDIDATES)
            best = candidates[optimal(correlations(weights, candidates, candidates), noise, rows)]
            shares.append([predicted(truth, design, places) for design in (maximin(rows, factors, random), best)])
        hypercube, known = numpy.median(shares, axis=0)
        print(f"{rows} rows: hypercube {hypercube:.3f}, optimal {known:.3f}", flush=True)


if __name__ == "__main__":
    main()
