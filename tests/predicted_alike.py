"""Compare the NumPy predictor with decore: `predicted_alike.py predict.py MODEL TABLE PREDICTED`.

Means, standard deviations and ends of intervals agree to 1e-12 of the output's spread in the model, probabilities to 1e-12. The predictor
loads the model without pyarrow.
"""

import importlib.util
import sys

import numpy as np
import pyarrow.parquet as parquet

specification = importlib.util.spec_from_file_location("predict", sys.argv[1])
predictor = importlib.util.module_from_spec(specification)
specification.loader.exec_module(predictor)

arrow = {name: sys.modules.pop(name) for name in list(sys.modules) if name.partition(".")[0] == "pyarrow"}
sys.modules["pyarrow"] = None
model = predictor.load(sys.argv[2])
sys.modules.update(arrow)
columns = parquet.read_table(sys.argv[2])
assert all(np.array_equal(columns[name], model["columns"][name], equal_nan=True) for name in columns.column_names), "other columns"
rows, ours = predictor._read(sys.argv[3]), parquet.read_table(sys.argv[4])
found, compared, worst = predictor.predict(model, rows), 0, 0.0
missing = {f"{o['output']}{end}" for o in model["figures"]["outputs"] for end in ("", "_std_dev", "_low", "_high")} - set(found)
assert not missing, missing
for name, values in found.items():
    if name == "outside":
        assert list(values) == [text != "" for text in ours["extrapolated"].to_pylist()]
        continue
    output = next(o["output"] for o in model["figures"]["outputs"] if name.startswith(o["output"]))
    spread = np.nanstd(model["columns"][output])
    theirs = np.asarray(ours[name])
    far = np.abs(values - theirs)
    if not name.endswith("_probability"):
        far = far / spread
    assert len(far) >= 5 and far.max() < 1e-12, f"{name}: {far.max()} of {len(far)}"
    compared, worst = compared + 1, max(worst, far.max())
print(f"{compared} columns of {len(ours)} rows are equal to {worst:.0e}")
assert compared >= 4 * len(model["figures"]["outputs"])
