"""Latin hypercubes of other programs: prints tool, criterion, factors, points, value, CPU seconds as JSON lines."""

import json
import sys
import time

import numpy as np
from scipy.spatial.distance import pdist
from scipy.stats import qmc


def report(tool, criterion, factors, points, sample, seconds):
    """Distances are in units of a stratum; hypercubes are moved to their strata's middles first."""
    centred = (np.floor(np.asarray(sample) * points) + 0.5) / points
    value = pdist(centred).min() * points if criterion == "distance" else qmc.discrepancy(centred)
    print(json.dumps([tool, criterion, factors, points, float(value), seconds]), flush=True)


def timed(make):
    start = time.process_time()
    sample = make()
    return sample, time.process_time() - start


def openturns(factors, points, criterion, steps):
    import openturns as ot

    ot.TBB.Disable()
    ot.RandomGenerator.SetSeed(1)
    lhs = ot.LHSExperiment(ot.JointDistribution([ot.Uniform(0, 1)] * factors), points)
    lhs.setAlwaysShuffle(True)
    space = ot.SpaceFillingPhiP(50) if criterion == "distance" else ot.SpaceFillingC2()
    annealing = ot.SimulatedAnnealingLHS(lhs, space, ot.GeometricProfile(10.0, 0.999, steps))
    return np.array(annealing.generate())


def smt(factors, points):
    from smt.sampling_methods import LHS

    try:
        sampling = LHS(xlimits=np.array([[0.0, 1.0]] * factors), criterion="ese", seed=1)
    except Exception:
        sampling = LHS(xlimits=np.array([[0.0, 1.0]] * factors), criterion="ese", random_state=1)
    return sampling(points)


for argument in sys.argv[1:]:
    factors, points, steps = (int(word) for word in argument.split(","))
    for name in ("random-cd", "lloyd"):
        sample, seconds = timed(lambda: qmc.LatinHypercube(factors, optimization=name, rng=1).random(points))
        for criterion in ("distance", "discrepancy"):
            report("SciPy " + name, criterion, factors, points, sample, seconds)
    sample, seconds = timed(lambda: smt(factors, points))
    report("SMT ESE", "distance", factors, points, sample, seconds)
    for criterion in ("distance", "discrepancy"):
        sample, seconds = timed(lambda: openturns(factors, points, criterion, steps))
        report("OpenTURNS annealing", criterion, factors, points, sample, seconds)
