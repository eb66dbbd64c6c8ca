# %% [markdown]
# # Compare sensitivities with SALib
#
# decore and SALib compute Sobol' indices from the same rows: a Saltelli design that decore runs.

# %%
import matplotlib.pyplot as plt
import numpy as np
import SALib.analyze.sobol  # type: ignore[import-untyped]

import decore

OUTPUT = "delivered_work_j"

study = decore.Study("studies/predictor.toml", {"duration_s": 0.2, "design.base_points": 64})
dataset = study.run("out/sensitivities", progress=True)
names = [factor.name for factor in study.factors]
print(f"{len(study)} rows of {len(names)} factors")

# %%
analysis = dataset.analyse([OUTPUT], estimator="salib", bootstrap=200)
own = analysis.table.to_pandas()
print(analysis)

# %%
values = np.asarray(dataset.runs[OUTPUT], dtype=float)
problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
salib = SALib.analyze.sobol.analyze(problem, values, calc_second_order=False, num_resamples=100, seed=1)

# %%
total = own[(own["output"] == OUTPUT) & (own["index"] == "st")].set_index("factor")["value"][names]
difference = np.abs(total.to_numpy() - salib["ST"]).max()
print(f"largest difference of a total index: {difference:.1e}")
if difference > 1e-9:
    raise SystemExit("decore and SALib differ")

# %%
place = np.arange(len(names))
plt.figure(figsize=(6, 3.5))
plt.bar(place - 0.2, total, 0.4, label="decore")
plt.bar(place + 0.2, salib["ST"], 0.4, label="SALib")
plt.xticks(place, names)
plt.ylabel("total index of the delivered work")
plt.legend()
plt.tight_layout()
plt.savefig("out/sensitivities.png")
