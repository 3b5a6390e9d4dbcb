"""Two clusters of pixel colours, by k-means and by a mixture of two Gaussians: the slow references.

As in Stone, Mangan, Ardin & Webb (2014), RSS, doi 10.15607/RSS.2014.X.047, section II.E: pixels by their values alone,
without regard to where they lie. Both give a score per pixel and the threshold at which one cluster becomes the other.
"""

import warnings

import numpy as np
from numpy.typing import NDArray

N_RESTARTS = 7  # of k-means; Stone et al. (2014), section II.E
MAX_STEPS = 300  # of the mixture; more than any photograph tried has needed

Singles = NDArray[np.float32]


def kmeans_score(points: NDArray[np.float32], seed: int) -> tuple[Singles, float]:
    """Place of each pixel along the line through both centres, and the middle between them, where the clusters meet.

    Parameters
    ----------
    points : (pixel, feature) array
    seed : of the first centres
    """
    from sklearn.cluster import KMeans

    centres = KMeans(n_clusters=2, n_init=N_RESTARTS, random_state=seed).fit(points).cluster_centers_.astype(np.float64)
    centres = centres[np.argsort(centres.sum(axis=1))]  # so that more is brighter, whatever the seed
    along = centres[1] - centres[0]
    along /= np.linalg.norm(along)
    return (points @ along.astype(np.float32)).astype(np.float32), float(centres.mean(axis=0) @ along)


def mixture_score(points: NDArray[np.float32], seed: int) -> tuple[Singles, float]:
    """Probability of each pixel to be of the brighter of two Gaussians, each with a covariance of its own, and 1/2.

    Parameters
    ----------
    points : (pixel, feature) array
    seed : of the k-means that it starts from
    """
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.mixture import GaussianMixture

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # the classes no longer change then
        mixture = GaussianMixture(n_components=2, max_iter=MAX_STEPS, random_state=seed).fit(points.astype(np.float64))
    brighter = int(np.argmax(mixture.means_.sum(axis=1)))
    return mixture.predict_proba(points.astype(np.float64))[:, brighter].astype(np.float32), 0.5
