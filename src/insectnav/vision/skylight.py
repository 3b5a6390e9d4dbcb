"""Sky in ordinary photographs, without training: bright, bluish or neutral, smooth, and joined to what is above.

Built for people without an ultraviolet camera. Brightness alone takes sunlit walls for sky and blue sky for ground.
Four things that hold for daylight skies set them apart: skylight is hardly ever yellowish where the white balance is
sound, while what the sun lights mostly is; it is smooth from pixel to pixel, while leaves, bricks and twigs are not; in
a picture of shade, lit surfaces and sky, the sky is the brightest of three classes; and sky hangs together from the top
of a picture ahead, or from the zenith.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import check_range
from insectnav.vision.sky_channels import Picture, Singles, one_channel
from insectnav.vision.sky_geometry import Bools, Geometry
from insectnav.vision.sky_levels import LEFT_OUT
from insectnav.vision.sky_thresholds import histogram, upper_of_three_classes


@dataclass(frozen=True, kw_only=True)
class SkylightParams:
    """Constants of the method for one kind of view; docs/sky-segmentation.md says how each was chosen.

    "Chosen" is on every other photograph of a set of its view, 240 × 180 streets or 320 × 320 fisheye pictures of the
    sky, also with errors of the white balance of 3 %, and measured on the others. Lengths are in pixels of the reduced
    picture.
    """

    blue_weight: float  # of blue - red where positive; chosen
    yellow_weight: float  # of red - blue where positive; chosen
    joins_first: bool  # whether sky grows into its rough edge before it is asked what hangs together; see `AHEAD`
    texture_weight: float = 5.0  # of the SD of brightness over 3 × 3 pixels; chosen
    edge_texture_weight: float = 1.25  # the same for pixels at the edge of sky, which have ground beside them; chosen
    lowest: float = -1.0  # of the score, as a share of white: darker or rougher is all the same; chosen
    highest: float = 1.2  # of the score: bluer is all the same; chosen
    top_share: float = 0.01  # of the rows of a view ahead that sky must reach up to; assumed
    zenith_share: float = 0.3  # of the height of a view up within which sky is taken for what it is; chosen
    patch_share: float = 0.004  # of a view up that a patch of sky apart from the rest must fill; chosen
    likeness: float = 0.3  # such a patch may be darker by this share of what sky lies above the threshold; chosen
    n_grow: int = 1  # pixels by which sky grows into its rough edge; chosen
    balance_share: float = 0.1  # of the rows of a view ahead in which the white balance is looked for; assumed
    balance_percentile: float = 10.0  # of blue - red among bright pixels there that counts as neutral; assumed
    most_tolerance: float = 0.15  # of the white balance, as a share of white; assumed
    white_percentile: float = 99.0  # of the brightness that counts as white; assumed
    working_side: int = 320  # [px] larger pictures are reduced to this shorter side; the largest that was tried

    def __post_init__(self) -> None:
        for name in ("blue_weight", "yellow_weight", "texture_weight", "edge_texture_weight", "n_grow"):
            check_range(name, getattr(self, name), 0.0, 100.0)
        for name in ("zenith_share", "top_share", "balance_share", "patch_share", "likeness", "most_tolerance"):
            check_range(name, getattr(self, name), 0.0, 1.0)
        check_range("working_side", self.working_side, 16, 10_000, "px")


# Ahead, clouds with hard edges may lie between the top and the horizon, and sunlit ones are yellowish: they are joined
# across their edges, and colour counts for little. Up, walls in the sun stand all round, and colour tells them.
AHEAD = SkylightParams(blue_weight=0.0, yellow_weight=2.0, joins_first=True)
UP = SkylightParams(blue_weight=1.0, yellow_weight=7.0, joins_first=False)
HALF_WHITE = 0.5  # brightness from which on a pixel at the top tells of the white balance; assumed
FLAT = 1e-6  # range of a picture, white being 1, that is rounding


@dataclass(frozen=True, kw_only=True, eq=False)
class SkylightResult:
    """A mask of the full size, and what it came from, at the reduced size.

    Parameters
    ----------
    mask : (rows, columns) array of bool
    threshold : of the score, white being 1
    score : reduced picture of how much each pixel is like sky
    brightness : reduced picture
    reduced_mask, levels : of the reduced picture, the latter its elevation levels
    """

    mask: Bools
    threshold: float
    score: Singles
    brightness: Singles
    reduced_mask: Bools
    levels: NDArray[np.uint8]


def skylight(picture: Picture, where: Geometry, params: SkylightParams | None = None) -> SkylightResult | None:
    """Sky of a picture of three bands or one; None where all pixels that count are alike.

    Parameters
    ----------
    picture : (rows, columns, 3) red, green, blue, or (rows, columns), of any type
    where : elevation of the pixels, and which of them count
    params : None for `UP` where the zenith is in the picture, `AHEAD` where not

    Notes
    -----
    With mean brightness g, blue and red as shares of white, and σ the standard deviation of g over 3 × 3 pixels,

        v = blue + a max(blue − red, 0) − b max(red − blue − t, 0) − c σ,

    cut off at both ends. The tolerance t is how yellowish the bright pixels at the top, or about the zenith, are, so
    that the white balance of the camera matters little. The threshold is the upper one of three classes (Otsu 1979).
    Pixels above it are opened by 3 × 3; of what is joined, the parts are kept that reach the top rows (view ahead) or
    the zenith; in a view up also others that are large and as bright. Colour, smoothness and position are the cues of
    many detectors of sky, among them Shen & Wang (2013), Int. J. Adv. Robot. Syst. 10:362, doi 10.5772/56884; this
    combination is ours.
    """
    params = params or (UP if where.looks_up else AHEAD)
    reduced, levels = _reduced(picture, where, params)
    counts_here = levels != LEFT_OUT
    brightness, raw = _brightness_and_blueness(reduced, levels, where.looks_up, params)
    if np.ptp(raw[counts_here]) < FLAT:
        return None
    texture = _texture(brightness, counts_here)
    score = np.clip(raw - np.float32(params.texture_weight) * texture, params.lowest, params.highest)
    counts = histogram(score, levels)
    if counts is None:
        return None
    threshold = upper_of_three_classes(counts)
    mask = _opened((score > threshold) & counts_here)
    at_edge = (raw - np.float32(params.edge_texture_weight) * texture > threshold) & counts_here
    if params.joins_first:
        mask = _grown(mask, at_edge, params.n_grow)
    mask = _joined_to_the_top(mask, raw, levels, where.looks_up, threshold, params)
    if not params.joins_first:
        mask = _grown(mask, at_edge, params.n_grow)
    return SkylightResult(
        mask=_enlarged(mask, where.levels.shape) & where.valid,
        threshold=threshold,
        score=score,
        brightness=brightness,
        reduced_mask=mask,
        levels=levels,
    )


def _reduced(picture: Picture, where: Geometry, params: SkylightParams) -> tuple[Picture, NDArray[np.uint8]]:
    """The picture and its levels, reduced to what the constants were chosen for."""
    import cv2

    rows, columns = picture.shape[:2]
    factor = min(rows, columns) / params.working_side
    levels: NDArray[Any] = where.levels
    if factor > 1.0:
        size = (round(columns / factor), round(rows / factor))
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
        levels = cv2.resize(levels, size, interpolation=cv2.INTER_NEAREST)
    return picture, levels


def _brightness_and_blueness(
    picture: Picture, levels: NDArray[np.uint8], looks_up: bool, params: SkylightParams
) -> tuple[Singles, Singles]:
    """Mean of the bands, and blue with its bonus and penalty; of one band both are the band. White is 1."""
    from insectnav.vision.sky_histogram_kernel import sky_cues

    inside = levels != LEFT_OUT
    brightness = one_channel(picture, "mean").astype(np.float32)
    sample = brightness[::2, ::2][inside[::2, ::2]]
    white = float(np.percentile(sample, params.white_percentile)) if sample.size else 0.0
    scale = np.float32(1.0 / (white or float(brightness[inside].max()) or 1.0))
    if picture.ndim == 2:
        scaled = brightness * scale
        return scaled, scaled
    top = _anchor(levels, looks_up, params.zenith_share, params.balance_share) & (brightness * scale > HALF_WHITE)
    tolerance = _yellowness(picture[top], scale, params)
    raw = np.empty(brightness.shape, np.float32)
    weights = np.float32(params.blue_weight), np.float32(params.yellow_weight)
    sky_cues(picture.reshape(-1, 3), scale, *weights, tolerance, brightness.reshape(-1), raw.reshape(-1))
    return brightness, raw


def _yellowness(pixels: NDArray[Any], scale: np.float32, params: SkylightParams) -> np.float32:
    """How yellowish bright pixels may be, from those that are sky if any are."""
    if not len(pixels):
        return np.float32(0.0)
    blueness = (pixels[:, 2].astype(np.float32) - pixels[:, 0].astype(np.float32)) * scale
    yellowness = -float(np.percentile(blueness, params.balance_percentile))
    return np.float32(min(max(yellowness, 0.0), params.most_tolerance))


def _texture(brightness: Singles, inside: Bools) -> Singles:
    """SD of brightness over 3 × 3 pixels, of those that count."""
    weight = inside.astype(np.float32)
    n = np.maximum(_sums(weight), 1.0)
    weighted = brightness * weight
    mean = _sums(weighted) / n
    return np.sqrt(np.maximum(_sums(brightness * weighted) / n - mean * mean, 0.0))


def _sums(values: Singles) -> Singles:
    """Sums over 3 × 3 pixels, nothing beyond the edges."""
    import cv2

    return np.asarray(cv2.boxFilter(values, -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT))


def _opened(mask: Bools) -> Bools:
    import cv2

    return np.asarray(cv2.morphologyEx(mask.view(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)).astype(bool))


def _grown(mask: Bools, allowed: Bools, n_pixels: int) -> Bools:
    import cv2

    for _ in range(n_pixels):
        mask = mask | (cv2.dilate(mask.view(np.uint8), np.ones((3, 3), np.uint8)).astype(bool) & allowed)
    return mask


def _joined_to_the_top(
    core: Bools, raw: Singles, levels: NDArray[np.uint8], looks_up: bool, threshold: float, params: SkylightParams
) -> Bools:
    """Parts of the core that hang together with the top, or with the zenith; the largest where none does."""
    import cv2

    n_parts, part, statistics, _ = cv2.connectedComponentsWithStats(core.view(np.uint8), connectivity=4)
    if n_parts == 1:
        return core
    anchor = _anchor(levels, looks_up, params.zenith_share, params.top_share)
    keep = np.bincount(part[anchor], minlength=n_parts) > 0
    keep[0] = False
    if not keep.any():
        keep[1 + np.argmax(statistics[1:, cv2.CC_STAT_AREA])] = True
    if looks_up:
        area = np.bincount(part.ravel(), minlength=n_parts).astype(np.float64)
        brightness = np.bincount(part.ravel(), raw.ravel(), minlength=n_parts) / np.maximum(area, 1.0)
        sky = float(np.average(brightness[keep], weights=area[keep]))
        is_large = area >= params.patch_share * np.count_nonzero(levels != LEFT_OUT)
        keep |= is_large & (brightness > sky - params.likeness * (sky - threshold))
        keep[0] = False
    return np.asarray(keep[part])


def _anchor(levels: NDArray[np.uint8], looks_up: bool, zenith_share: float, top_share: float) -> Bools:
    """Pixels that are above all others: about the zenith, or the first rows that count in each column."""
    inside = levels != LEFT_OUT
    if looks_up:
        return np.asarray(inside & (levels > (1.0 - zenith_share) * int(levels[inside].max())))
    n_rows = max(1, round(top_share * levels.shape[0]))
    first = np.argmax(inside, axis=0)
    row = np.arange(levels.shape[0])[:, None]
    return np.asarray(inside & (row >= first) & (row < first + n_rows))


def _enlarged(mask: Bools, size: tuple[int, ...]) -> Bools:
    import cv2

    if mask.shape == size:
        return mask
    full = cv2.resize(mask.astype(np.float32), (size[1], size[0]), interpolation=cv2.INTER_LINEAR)
    return np.asarray(full > 0.5)
