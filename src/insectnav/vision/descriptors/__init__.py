"""Descriptors of views: pictures or panoramas in, vectors out, each with the metric by which they are compared."""

from functools import partial

from insectnav.vision.descriptors.binary_sky import binary_sky, panorama_binary_sky
from insectnav.vision.descriptors.descriptor import Descriptor
from insectnav.vision.descriptors.frequency_strip import frequency_strip
from insectnav.vision.descriptors.harmonic_basis import amplitude_spectrum, harmonic_pairs, real_harmonics
from insectnav.vision.descriptors.patch_normalised import NOTHING, patch_normalised
from insectnav.vision.descriptors.retinotopic import retinotopic
from insectnav.vision.descriptors.sky_contour import (
    contour_amplitudes,
    contour_coefficients,
    panorama_contour_amplitudes,
    redraw_contour,
    sky_contour,
)
from insectnav.vision.descriptors.spherical_harmonics import (
    harmonic_amplitudes,
    harmonic_coefficients,
    sphere_amplitudes,
    sphere_coefficients,
)
from insectnav.vision.descriptors.wrapped_disk import wrap_to_disk, zernike_disk_amplitudes, zernike_disk_coefficients
from insectnav.vision.descriptors.zernike import zernike_amplitudes, zernike_coefficients
from insectnav.vision.descriptors.zernike_basis import radial_polynomials, zernike_pairs, zernike_weights

MILFORD_2012 = "Milford & Wyeth 2012, doi 10.1109/ICRA.2012.6224623"
STONE_2018 = "Stone et al. 2018, doi 10.1098/rsfs.2018.0010"
DESCRIPTORS = {
    descriptor.name: descriptor
    for descriptor in (
        Descriptor(
            name="retinotopic",
            describe=retinotopic,
            is_heading_free=False,
            source="Zeil et al. 2003, doi 10.1364/JOSAA.20.000450",
        ),
        Descriptor(name="zernike", describe=zernike_amplitudes, is_heading_free=True, source=STONE_2018),
        Descriptor(
            name="zernike-orthonormal",
            describe=partial(zernike_amplitudes, order=40, weights="orthonormal"),
            is_heading_free=True,
            source="Khotanzad & Hong 1990, doi 10.1109/34.55109",
        ),
        Descriptor(name="zernike-disk", describe=zernike_disk_amplitudes, is_heading_free=True, source=STONE_2018),
        Descriptor(
            name="frequency-strip",
            describe=frequency_strip,
            is_heading_free=True,
            source="Stürzl & Mallot 2006, doi 10.1016/j.robot.2005.12.001",
        ),
        Descriptor(  # of panoramas from −15° to 90° in pixels of at most 3°
            name="spherical-harmonics",
            describe=partial(harmonic_amplitudes, n_degrees=60),
            is_heading_free=True,
            source="Stone et al., ICRA 2016; sampling: Driscoll & Healy 1994, doi 10.1006/aama.1994.1008",
        ),
        Descriptor(
            name="patch-normalised",
            describe=patch_normalised,
            is_heading_free=False,
            metric="cosine",
            source=MILFORD_2012,
        ),
        Descriptor(
            name="patch-normalised-v1",
            describe=partial(patch_normalised, rounded=True, flat_patch=NOTHING),
            is_heading_free=False,
            metric="openseqslam-v1",
            source=f"OpenSeqSLAM v1, after {MILFORD_2012}",
        ),
        Descriptor(
            name="binary-sky",
            describe=panorama_binary_sky,
            is_heading_free=False,
            metric="hamming",
            source="Stone et al., RSS 2014, doi 10.15607/RSS.2014.X.047",
        ),
        Descriptor(
            name="sky-contour",
            describe=panorama_contour_amplitudes,
            is_heading_free=True,
            source="Persoon & Fu 1977, doi 10.1109/TSMC.1977.4309681",
        ),
    )
}

__all__ = [
    "DESCRIPTORS",
    "Descriptor",
    "amplitude_spectrum",
    "binary_sky",
    "contour_amplitudes",
    "contour_coefficients",
    "frequency_strip",
    "harmonic_amplitudes",
    "harmonic_coefficients",
    "harmonic_pairs",
    "panorama_binary_sky",
    "panorama_contour_amplitudes",
    "patch_normalised",
    "radial_polynomials",
    "real_harmonics",
    "redraw_contour",
    "retinotopic",
    "sky_contour",
    "sphere_amplitudes",
    "sphere_coefficients",
    "wrap_to_disk",
    "zernike_amplitudes",
    "zernike_coefficients",
    "zernike_disk_amplitudes",
    "zernike_disk_coefficients",
    "zernike_pairs",
    "zernike_weights",
]
