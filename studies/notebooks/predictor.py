# %% [markdown]
# # A predictor with grouped validation
#
# `export` writes a flat table with groups of dependent rows. Use whole groups in each fold of the validation. Otherwise
# the model is tested on rows that depend on its training rows.

# %%
import matplotlib.pyplot as plt
import pandas as pd
from sklearn.ensemble import HistGradientBoostingRegressor  # type: ignore[import-untyped]
from sklearn.model_selection import GroupKFold, KFold, cross_val_predict  # type: ignore[import-untyped]
from sklearn.metrics import r2_score  # type: ignore[import-untyped]
from sklearn.pipeline import make_pipeline  # type: ignore[import-untyped]
from sklearn.preprocessing import StandardScaler  # type: ignore[import-untyped]

import decore

study = decore.Study("studies/predictor.toml", {"duration_s": 0.3, "design.base_points": 64})
dataset = study.run("out/predictor", progress=True)
written = dataset.export("out/predictor_features", splits=[0.8, 0.2], replace=True)
print(written)

# %%
table = pd.read_parquet(written.files[0].path)
table = table[table["status"] == "done"]
inputs, target = table.filter(like="factor_"), table["work_j"]
print(f"{len(table)} rows in {table['group_id'].nunique()} groups")

# %%
model = make_pipeline(StandardScaler(), HistGradientBoostingRegressor(random_state=0, max_iter=100))
by_group = cross_val_predict(model, inputs, target, cv=GroupKFold(5), groups=table["group_id"])
at_random = cross_val_predict(model, inputs, target, cv=KFold(5, shuffle=True, random_state=0))
print(f"R2 by group {r2_score(target, by_group):.3f}, at random {r2_score(target, at_random):.3f}")

# %% [markdown]
# The same with `to_pandas()`, compared with decore's own models.

# %%
runs = dataset.runs.to_pandas()
model.fit(runs.filter(like="factor_"), runs["delivered_work_j"])
places = decore.Study("studies/predictor.toml", {"design.seed": 2, "design.base_points": 16}).rows()
models = dataset.surrogate(["delivered_work_j"], least_q2=0.5)
own = models.predict(places).to_pandas()
said = model.predict(places.to_pandas().filter(like="factor_"))

# %%
plt.figure(figsize=(4.5, 4.5))
plt.plot(own["delivered_work_j"], said, ".")
ends = [own["delivered_work_j"].min(), own["delivered_work_j"].max()]
plt.plot(ends, ends, "k-", linewidth=0.8)
plt.xlabel("decore's model: work in J")
plt.ylabel("scikit-learn: work in J")
plt.tight_layout()
plt.savefig("out/predictor.png")
