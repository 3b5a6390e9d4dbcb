"""What all places of a map have in common: how their descriptors were made, and where they lie on Earth."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from insectnav.checks import InputError, check_choice, check_count, check_range, quoted
from insectnav.matching.difference import METRICS

Setting = str | int | float | bool | None
MOST_FEATURES = 2**20
LONGEST_TEXT = 1000  # [character] of a name or a setting
MOST_SETTINGS = 100


@dataclass(frozen=True, kw_only=True)
class MapAbout:
    """What all places of a map have in common; queries must share it, but for the origin.

    Parameters
    ----------
    descriptor : a name in `insectnav.vision.descriptors.DESCRIPTORS`, or a word of your own
    metric : one of `insectnav.matching.METRICS`
    n_features : of each descriptor
    camera : what took the frames, in one line; "" if unknown
    settings : all else that the features follow from
    origin_deg : latitude and longitude [°] of position (0, 0), if known
    """

    descriptor: str
    metric: str
    n_features: int
    camera: str = ""  # unknown
    settings: Mapping[str, Setting] = field(default_factory=dict)  # none
    origin_deg: tuple[float, float] | None = None  # unknown

    def __post_init__(self) -> None:
        check_text("descriptor", self.descriptor)
        if not self.descriptor:
            raise InputError("descriptor is an empty word, expected what the features are, such as 'zernike'")
        check_choice("metric", self.metric, METRICS)
        check_count("n_features", self.n_features)
        if self.n_features > MOST_FEATURES:
            raise InputError(f"n_features is {self.n_features}, expected at most {MOST_FEATURES}")
        check_text("camera", self.camera)
        object.__setattr__(self, "settings", _checked_settings(self.settings))
        if self.origin_deg is not None:
            object.__setattr__(self, "origin_deg", _checked_origin(self.origin_deg))

    def as_json(self) -> dict[str, Any]:
        """The same in words that JSON knows."""
        origin = None if self.origin_deg is None else list(self.origin_deg)
        return {
            "descriptor": self.descriptor,
            "metric": self.metric,
            "n_features": int(self.n_features),
            "camera": self.camera,
            "settings": dict(self.settings),
            "origin_deg": origin,
        }

    def check_same(self, other: "MapAbout", whose: str) -> None:
        """Refuse what was described otherwise than the places of this map.

        Parameters
        ----------
        other : MapAbout
            Of queries or of another map; where either camera is unknown they may be the same.
        whose : words for the other, in the plural

        Raises
        ------
        InputError
            If anything but the origin differs; it names the first such thing.
        """
        pairs: list[tuple[str, Setting, Setting]] = [
            (name, getattr(other, name), getattr(self, name)) for name in ("descriptor", "metric", "n_features")
        ]
        if self.camera and other.camera:
            pairs.append(("camera", other.camera, self.camera))
        for name in sorted({*self.settings, *other.settings}):
            pairs.append((f"setting {quoted(name)}", other.settings.get(name), self.settings.get(name)))
        for name, theirs, ours in pairs:
            if theirs != ours:
                raise InputError(
                    f"{name} of {whose} is {quoted(theirs)}, expected {quoted(ours)} as of the map: "
                    "described in another way?"
                )


def about_from_json(found: object) -> MapAbout:
    """What `MapAbout.as_json` gave.

    Raises
    ------
    InputError
        If it is anything else.
    """
    names = {"descriptor", "metric", "n_features", "camera", "settings", "origin_deg"}
    if not isinstance(found, dict) or set(found) != names:
        raise InputError(f"what the map is about is no record of {', '.join(sorted(names))}")
    origin = found["origin_deg"]
    return MapAbout(**{**found, "origin_deg": tuple(origin) if isinstance(origin, list) else origin})


def check_text(name: str, text: object, limit: int = LONGEST_TEXT) -> None:
    """Refuse anything but a text of moderate length that has a form in UTF-8."""
    if not isinstance(text, str):
        raise InputError(f"{name} is {quoted(text)}, expected text")
    if len(text) > limit:
        raise InputError(f"{name} has {len(text)} characters, expected at most {limit}")
    try:
        text.encode()
    except UnicodeEncodeError:
        raise InputError(f"{name} {quoted(ascii(text))} holds half a character, expected text") from None


def _checked_settings(settings: object) -> dict[str, Setting]:
    if not isinstance(settings, Mapping) or len(settings) > MOST_SETTINGS:
        raise InputError(f"settings are {quoted(settings)}, expected at most {MOST_SETTINGS} names with values")
    for name, value in settings.items():
        check_text("name of a setting", name)
        if isinstance(value, str):
            check_text(f"setting {quoted(name)}", value)
        elif not (value is None or isinstance(value, bool | int | float)) or (
            isinstance(value, float) and not math.isfinite(value)
        ):
            raise InputError(f"setting {quoted(name)} is {quoted(value)}, expected text, a finite number or nothing")
    return dict(settings)


def _checked_origin(origin: object) -> tuple[float, float]:
    if not isinstance(origin, tuple) or len(origin) != 2:
        raise InputError(f"origin_deg is {quoted(origin)}, expected latitude and longitude")
    check_range("latitude of origin_deg", origin[0], -90.0, 90.0, "°")
    check_range("longitude of origin_deg", origin[1], -180.0, 180.0, "°")
    return float(origin[0]), float(origin[1])
