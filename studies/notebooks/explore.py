# %% [markdown]
# # Explore a study
#
# Simulate one row, run a sweep, and look at it with pandas. Run the cells in the folder of the sources.

# %%
import matplotlib.pyplot as plt

import decore

study = decore.Study("studies/placement.toml", {"duration_s": 0.5, "design.rows": 60})
row = study.scene(3, signals=["hammer_casting_force_n"])
print(row)

# %%
if row.signals is None:
    raise SystemExit(row.reason)
signal = row.signals.to_pandas()
plt.figure(figsize=(7, 3))
plt.plot(signal["time_s"], signal["hammer_casting_force_n"] / 1e3)
plt.xlabel("time in s")
plt.ylabel("force on the casting in kN")
plt.tight_layout()
plt.savefig("out/explore_force.png")

# %%
dataset = study.run("out/explore", progress=True)
runs = dataset.runs.to_pandas()
print(runs[["factor_pressure", "factor_position", "delivered_work_j", "total_air_used_nl"]].describe())

# %%
plt.figure(figsize=(6, 4))
points = plt.scatter(
    runs["factor_pressure"],
    runs["delivered_work_j"],
    c=1e3 * runs["factor_standoff"],
)
plt.xlabel("supply pressure in bar")
plt.ylabel(f"delivered work in {dataset.runs.units['delivered_work_j']}")
plt.colorbar(points, label="standoff in mm")
plt.tight_layout()
plt.savefig("out/explore_work.png")

# %%
report = dataset.report(rank_by="delivered_work_j", best=3)
print(f"best rows: {[best.row for best in report.best]}")
