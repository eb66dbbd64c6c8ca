"""Latin hypercubes of other programs: prints tool, criterion, factors, points, value, CPU seconds, runs as JSON lines.

Each argument is factors,points,annealing steps,CPU seconds for distances,CPU seconds for discrepancies. A program runs once, and
again with other seeds as long as its time is not used up: the best of all runs counts.
"""

import json
import sys
import time

import numpy as np
from scipy.spatial.distance import pdist
from scipy.stats import qmc


def measure(criterion, points, sample):
    """Distances are in units of a stratum; hypercubes are moved to their strata's middles first."""
    centred = (np.floor(np.asarray(sample) * points) + 0.5) / points
    return pdist(centred).min() * points if criterion == "distance" else qmc.discrepancy(centred)


def report(tool, criterion, size, budget, make):
    """Best of as many runs as fit into the time, at least one."""
    start, values = time.process_time(), []
    while not values or time.process_time() - start < budget:
        values.append(measure(criterion, size[1], make(len(values) + 1)))
    best = max(values) if criterion == "distance" else min(values)
    print(json.dumps([tool, criterion, *size, float(best), time.process_time() - start, len(values)]), flush=True)


def openturns(factors, points, criterion, steps, seed):
    import openturns as ot

    ot.TBB.Disable()
    ot.RandomGenerator.SetSeed(seed)
    lhs = ot.LHSExperiment(ot.JointDistribution([ot.Uniform(0, 1)] * factors), points)
    lhs.setAlwaysShuffle(True)
    space = ot.SpaceFillingPhiP(50) if criterion == "distance" else ot.SpaceFillingC2()
    annealing = ot.SimulatedAnnealingLHS(lhs, space, ot.GeometricProfile(10.0, 0.999, steps))
    return np.array(annealing.generate())


def smt(factors, points, seed):
    from smt.sampling_methods import LHS

    return LHS(xlimits=np.array([[0.0, 1.0]] * factors), criterion="ese", seed=seed)(points)


def scipy(factors, points, name, seed):
    return qmc.LatinHypercube(factors, optimization=name, rng=seed).random(points)


for argument in sys.argv[1:]:
    words = argument.split(",")
    factors, points, steps = (int(word) for word in words[:3])
    size = (factors, points)
    for criterion, budget in zip(("distance", "discrepancy"), map(float, words[3:])):
        # Voronoi cells in ten dimensions take gigabytes and many minutes.
        for name in ("random-cd", "lloyd") if factors <= 8 else ("random-cd",):
            report("SciPy " + name, criterion, size, budget, lambda seed: scipy(*size, name, seed))
        if criterion == "distance":
            report("SMT ESE", criterion, size, budget, lambda seed: smt(*size, seed))
        report("OpenTURNS annealing", criterion, size, budget, lambda seed: openturns(*size, criterion, steps, seed))
