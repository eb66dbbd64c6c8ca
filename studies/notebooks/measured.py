# %% [markdown]
# # Compare a signal with a measurement
#
# The measurement is made up: the casting's velocity with another fixture stiffness, with noise and a clock that is 12 ms late.

# %%
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import decore

SIGNAL = "part_heave_velocity_m_s"

study = decore.Study("studies/placement.toml", {"duration_s": 0.5, "design.rows": 24})
rig = {"position": 0.0, "pressure": 5.0, "standoff": 0.085, "fixture_stiffness": 4e7}
truth = study.scene(rig, signals=[SIGNAL])
if truth.signals is None:
    raise SystemExit(truth.reason)
record = truth.signals.to_pandas()
noise = np.random.default_rng(1).normal(0.0, 0.01, len(record))
measured = pd.DataFrame({"time_s": record["time_s"] + 0.012, "vibrometer": 1e3 * (record[SIGNAL] + noise)})
measured.to_csv("out/rig.csv", index=False)

# %% [markdown]
# Row 3 of the design is another position. You see this in the comparison.

# %%
result = study.write_scene(
    row=3,
    measured="out/rig.csv",
    channels=[f"{SIGNAL}=vibrometer:mm/s"],
    html="out/measured.html",
    replace=True,
    signals="out/measured.parquet",
)
print(result)

# %%
channel = result.measured[0]
signal = pd.read_parquet("out/measured.parquet")
offset_s = channel.offset_s
plt.figure(figsize=(7, 3))
plt.plot(signal["time_s"], signal[SIGNAL], label="row 3")
plt.plot(measured["time_s"] - offset_s, measured["vibrometer"] / 1e3, linewidth=0.7, label="measurement")
plt.xlabel("time in s")
plt.ylabel("velocity of the casting in m/s")
plt.legend()
plt.tight_layout()
plt.savefig("out/measured.png")
