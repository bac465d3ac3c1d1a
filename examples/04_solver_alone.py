"""The transport solver on its own
===============================

Unbalanced fused Gromov-Wasserstein transport between any two small graphs: a feature cost, two structure matrices, two
masses.
"""

# %%
# A path of four nodes and a path of three, with one feature each.
import numpy as np

import graft

source = np.array([0.0, 1.0, 2.0, 3.0])
target = np.array([0.1, 1.1, 2.9])
feature_cost = np.abs(source[:, None] - target[None, :])
structure = [np.abs(x[:, None] - x[None, :]) / 3 for x in (source, target)]

# %%
# Masses need not agree. With `em_rate` the target's masses adapt; without it they are as given.
result = graft.ufgw(feature_cost, *structure, np.full(4, 0.25), np.full(3, 1 / 3), eps=0.01, em_rate=0.4)
print(result.plan.round(3))
print("target mass", result.target_mass.round(3))
print(f"cost {result.cost:.4f}, converged {result.converged} in {result.n_iters} iterations")
