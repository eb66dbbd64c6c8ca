"""Holds the NumPy predictor to decore: `predicted_alike.py predict.py MODEL TABLE PREDICTED`.

Means and probabilities are equal to 1e-12 of the output's spread in the model, variances to that of its square.
"""

import importlib.util
import sys

import numpy as np
import pyarrow.parquet as parquet

specification = importlib.util.spec_from_file_location("predict", sys.argv[1])
predictor = importlib.util.module_from_spec(specification)
specification.loader.exec_module(predictor)

model, rows, ours = predictor.load(sys.argv[2]), parquet.read_table(sys.argv[3]), parquet.read_table(sys.argv[4])
found, compared, worst = predictor.predict(model, rows.to_pydict()), 0, 0.0
for name, values in found.items():
    if name == "outside":
        assert list(values) == [text != "" for text in ours["extrapolated"].to_pylist()]
        continue
    output = next(o["output"] for o in model["figures"]["outputs"] if name.startswith(o["output"]))
    spread = np.nanstd(model["columns"][output])
    theirs = np.asarray(ours[name])
    if name.endswith("_probability"):
        far = np.abs(values - theirs)
    elif name.endswith("_std_dev"):
        far = np.abs(values**2 - theirs**2) / spread**2
    elif name == output:
        far = np.abs(values - theirs) / spread
    else:
        continue
    assert len(far) > 50 and far.max() < 1e-12, f"{name}: {far.max()}"
    compared, worst = compared + 1, max(worst, far.max())
print(f"{compared} columns of {len(rows)} rows are equal to {worst:.0e}")
assert compared > 2
