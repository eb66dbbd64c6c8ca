"""Sobol' indices by SALib of outputs in a file of doubles: prints wall seconds and, per output, S1 and ST as JSON.

Usage: python sensitivity_reference.py FILE FACTORS OUTPUTS
"""

import json
import sys
import time

import numpy as np
from SALib.analyze import sobol


def main(file, factors, outputs):
    """Analyses every output of the file, one after the other."""
    table = np.fromfile(file).reshape(outputs, -1)
    problem = {"num_vars": factors, "names": [f"x{i}" for i in range(factors)], "bounds": [[0.0, 1.0]] * factors}
    start, found = time.perf_counter(), []
    for values in table:
        result = sobol.analyze(problem, values, calc_second_order=False, num_resamples=2, seed=1)
        found.append([result["S1"].tolist(), result["ST"].tolist()])
    print(json.dumps([time.perf_counter() - start, found]))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
