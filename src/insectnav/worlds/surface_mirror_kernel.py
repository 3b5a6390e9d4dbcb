"""Reflection at flat mirrors, compiled."""

from insectnav.lanes.compiled import kernel
from insectnav.worlds.shading_kernel import mirrored_share


@kernel
def reflect(ray, distance, eye, normal, optics, lift, start, second, share):
    """Write where the mirrored rays start, (ray, 3), where they go, (ray, 3), and the share mirrored, (ray,).

    ``optics`` (ray, 3) are refractive index, number of surfaces and share of metal; ``lift`` is how far from the mirror
    the second ray starts.
    """
    for k in range(ray.shape[0]):
        along = ray[k, 0] * normal[k, 0] + ray[k, 1] * normal[k, 1] + ray[k, 2] * normal[k, 2]
        side = -1.0 if along > 0.0 else 1.0
        for axis in range(3):
            second[k, axis] = ray[k, axis] - 2.0 * along * normal[k, axis]
            start[k, axis] = eye[axis] + distance[k] * ray[k, axis] + side * lift * normal[k, axis]
        share[k] = mirrored_share(optics, k, min(abs(along), 1.0))
