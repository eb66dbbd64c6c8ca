"""Filters and densities of scipy.signal for a signal that is computed alike elsewhere: prints them as JSON.

Usage: python benches/signal_reference.py > tests/data/signal_references.json
"""

import json

import numpy as np
import scipy
from scipy import signal

FILTERS = [(4, 4000.0, 50_000.0), (2, 4000.0, 100_000.0), (1, 30.0, 1000.0), (3, 120.0, 1000.0), (5, 400.0, 1000.0),
           (7, 250.0, 1000.0), (8, 20.0, 50_000.0), (9, 3.0, 1000.0)]
DENSITIES = [(1000.0, 256), (50_000.0, 255), (1000.0, 1000), (1000.0, 64)]


def samples(count=700):
    """Two lines, a trend and steps, without any function whose last bits differ from system to system."""
    k = np.arange(count)
    saw = (k * 37 % 101) / 101 - 0.5
    return 0.3 + 1e-3 * k + saw + np.where(k // 90 % 2 == 0, 1.5, -0.5) + ((k * k) % 13) / 26


def main():
    """Prints all references."""
    x = samples()
    filters = []
    for order, cutoff, rate in FILTERS:
        sos = signal.butter(order, cutoff, fs=rate, output="sos")
        filtered = signal.sosfiltfilt(sos, x)
        filters.append({"order": order, "cutoff_hz": cutoff, "rate_hz": rate, "sos": sos.tolist(), "filtered": filtered.tolist()})
    densities = []
    for rate, segment in DENSITIES:
        frequencies, power = signal.welch(x, rate, nperseg=segment)
        densities.append({"rate_hz": rate, "segment": segment, "resolution_hz": frequencies[1], "power": power.tolist()})
    source = f"scipy {scipy.__version__}: butter(output='sos'), sosfiltfilt, welch with their defaults"
    print(json.dumps({"source": source, "samples": x.tolist(), "filters": filters, "densities": densities}))


if __name__ == "__main__":
    main()
