"""Surrogates by SMT and egobox at their own defaults: prints per case and program Q2, coverage and seconds of the fit as JSON.

Usage: python surrogates_reference.py CASES (JSON: per case [rows, values] that are known and [rows, values] that are new)
"""

import json
import sys
import time
import warnings

import numpy as np


def smt(x, y):
    """SMT's kriging."""
    from smt.surrogate_models import KRG

    model = KRG(print_global=False)
    model.set_training_values(x, y)
    model.train()
    return model.predict_values, model.predict_variances


def egobox(x, y):
    """egobox' mixture of experts, of one expert."""
    import egobox as egx

    model = egx.Gpx.builder().fit(x, y)
    return model.predict, model.predict_var


def worth(fit, known, new):
    """Q2 and the share of 95 % intervals on the new rows, and the time of the fit."""
    (x, y), (places, truth) = ((np.array(rows, dtype=float), np.array(values, dtype=float)) for rows, values in (known, new))
    start = time.perf_counter()
    predict, variance = fit(x, y.reshape(-1, 1))
    seconds = time.perf_counter() - start
    mean, spread = np.ravel(predict(places)), np.sqrt(np.maximum(np.ravel(variance(places)), 0.0))
    q2 = 1.0 - np.sum((truth - mean) ** 2) / np.sum((truth - truth.mean()) ** 2)
    held = np.mean(np.abs(truth - mean) <= 1.959963984540054 * spread)
    return {"q2": float(q2), "coverage": float(held), "fit_s": seconds}


def main(file):
    """All cases, by both programs."""
    warnings.simplefilter("ignore")
    with open(file) as cases:
        found = [[worth(fit, *case) for fit in (smt, egobox)] for case in json.load(cases)]
    print(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1])
