# %% [markdown]
# # Numbers to compare with the paper
#
# Straightness of the way home and closest distance to the nest, under both sets of constants, with their uncertainty.
# After Stone et al. 2017, Fig. 5c and e, doi 10.1016/j.cub.2017.08.052.

# %%
import numpy as np

from insectnav.agents import random_routes, run_trials
from insectnav.central_complex import CODE_2017, THESIS
from insectnav.metrics.path_integration import distance_left

N_TRIALS, N_STEPS = 6400, 1500
routes = random_routes(N_TRIALS, N_STEPS, seed=11)

# %% Tortuosity L/C at 10 % noise: 1 / (1 − mean share of the way left after a path as long as the straight way).
for name, circuit in (("thesis", THESIS), ("code-2017", CODE_2017)):
    trials = run_trials(routes, circuit, n_inbound=N_STEPS, noise=0.1, seed=11)
    left = distance_left(trials["position"].values[:, N_STEPS - 1 :])
    left = left[np.isfinite(left)]
    tortuosity = 1.0 / (1.0 - left.mean())
    error = left.std(ddof=1) / np.sqrt(left.size) * tortuosity**2
    print(f"tortuosity, {name:9s}: {tortuosity:.3f} ± {error:.3f} (SE, n = {left.size})")

# %% Closest distance to the nest on the way home, by noise, with the 95 % confidence interval of the median.
for noise in (0.0, 0.1, 0.2, 0.3, 0.4):
    trials = run_trials(routes, CODE_2017, n_inbound=N_STEPS, noise=noise, seed=11)
    distance = np.sort(trials["closest_distance"].values)
    half_width = round(0.98 * np.sqrt(N_TRIALS))  # in ranks, from the binomial distribution
    low, median, high = distance[[N_TRIALS // 2 - half_width, N_TRIALS // 2, N_TRIALS // 2 + half_width]]
    print(
        f"closest distance, code-2017, noise {noise}: median {median:.2f} ({low:.2f} … {high:.2f}), "
        f"mean {distance.mean():.2f}, SD {distance.std(ddof=1):.2f} steps (n = {N_TRIALS})"
    )
