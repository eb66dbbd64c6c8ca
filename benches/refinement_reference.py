"""Least values that egobox' Egor finds: prints one per seed as JSON.

Usage: python refinement_reference.py FUNCTION FIRST ROWS SEEDS (FUNCTION: "Branin" or "Hartmann 6"; of ROWS evaluations FIRST are a design)
"""

import json
import sys

import egobox
import numpy as np

STEEP = np.array(
    [
        [10.0, 3.0, 17.0, 3.5, 1.7, 8.0],
        [0.05, 10.0, 17.0, 0.1, 8.0, 14.0],
        [3.0, 3.5, 1.7, 10.0, 17.0, 8.0],
        [17.0, 8.0, 0.05, 10.0, 0.1, 14.0],
    ]
)
MIDDLES = np.array(
    [
        [0.1312, 0.1696, 0.5569, 0.0124, 0.8283, 0.5886],
        [0.2329, 0.4135, 0.8307, 0.3736, 0.1004, 0.9991],
        [0.2348, 0.1451, 0.3522, 0.2883, 0.3047, 0.6650],
        [0.4047, 0.8828, 0.8732, 0.5743, 0.1091, 0.0381],
    ]
)


def branin(x):
    """Branin's function over the unit square."""
    a, b = 15.0 * x[:, 0] - 5.0, 15.0 * x[:, 1]
    bowl = (b - 5.1 / (4.0 * np.pi**2) * a**2 + 5.0 / np.pi * a - 6.0) ** 2
    return (bowl + 10.0 * (1.0 - 1.0 / (8.0 * np.pi)) * np.cos(a) + 10.0)[:, None]


def hartmann(x):
    """Hartmann's function of six factors."""
    off = np.einsum("wf,nwf->nw", STEEP, (x[:, None, :] - MIDDLES) ** 2)
    return -(np.exp(-off) @ np.array([1.0, 1.2, 3.0, 3.2]))[:, None]


def main(name, first, rows, seeds):
    """The least value for each seed."""
    function, factors = {"Branin": (branin, 2), "Hartmann 6": (hartmann, 6)}[name]
    found = []
    for seed in range(seeds):
        optimiser = egobox.Egor([[0.0, 1.0]] * factors, n_doe=first, seed=seed)
        ended = optimiser.minimize(function, max_iters=rows - first)
        values = np.asarray(ended.result.y_doe)[:, 0]
        assert len(values) <= rows, len(values)
        found.append(float(values.min()))
    print(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
