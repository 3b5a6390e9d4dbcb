"""When and where it is, and the weather: the light of a world over the time of a traverse."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, cast

import numpy as np

from insectnav.checks import InputError, check_choice, check_count, check_range, quoted
from insectnav.worlds.clouds import WEATHERS, weather_clouds
from insectnav.worlds.sky import EPOCH, Sky, sky_at
from insectnav.worlds.skylight import LOWEST_SUN
from insectnav.worlds.sun import utc


@dataclass(frozen=True, kw_only=True)
class LightParams:
    """Date, place and weather.

    Parameters
    ----------
    date : "YYYY-MM-DD"
    time : "HH:MM" or "HH:MM:SS"
        Of the first moment: local mean solar time, in which the sun stands highest at about 12:00 everywhere (UTC and
        4 min for each degree of longitude to the east), unless it ends with Z or an offset such as +01:00.
    latitude_deg, longitude_deg : float [°], north and east positive
    sun_deg : pair of float or None
        Azimuth clockwise from north and elevation [°] of a sun that stands still, whatever date and place say.
    weather : "clear", "scattered", "broken" or "overcast"
    turbidity : float
        Haze: 2 is very clear, 6 hazy.
    cloud_seed : int
    wind : pair of float [m/s], to the east and to the north

    Raises
    ------
    InputError
        If a value makes no sense.
    """

    date: str = "2014-04-11"  # spring, when ants and students go out
    time: str = "09:00"
    latitude_deg: float = 37.4  # Seville, where Cataglyphis velox of the thesis lives
    longitude_deg: float = -5.98
    sun_deg: tuple[float, float] | None = None
    weather: str = "clear"
    turbidity: float = 3.0
    cloud_seed: int = 0
    wind: tuple[float, float] = (8.0, 3.0)  # [m/s] as of `sky_at`

    def __post_init__(self) -> None:
        check_choice("weather", self.weather, WEATHERS)
        check_count("cloud seed", self.cloud_seed, minimum=0)
        check_range("latitude", self.latitude_deg, -90.0, 90.0, "degrees", "latitude and longitude swapped?")
        check_range("longitude", self.longitude_deg, -180.0, 180.0, "degrees")
        if self.sun_deg is not None:
            check_range("azimuth of the sun", self.sun_deg[0], -360.0, 360.0, "degrees")
            low = float(np.rad2deg(LOWEST_SUN))
            check_range("elevation of the sun", self.sun_deg[1], low, 90.0, "degrees", "azimuth comes first")
        first_moment(self)

    def moment(self, seconds: float) -> np.datetime64:
        """Time in UTC so many seconds after the first moment."""
        return first_moment(self) + np.timedelta64(round(seconds * 1e6), "us")

    def sky(self, seconds: float) -> Sky:
        """The sky so many seconds after the first moment.

        Raises
        ------
        InputError
            If the sun is below 2°.
        """
        moment = self.moment(seconds)
        settings: dict[str, Any] = {"turbidity": self.turbidity}
        if self.sun_deg is None:
            settings |= {"seed": self.cloud_seed, "wind": self.wind}
            return sky_at(moment, self.latitude_deg, self.longitude_deg, self.weather, **settings)
        azimuth, elevation = np.deg2rad(self.sun_deg).tolist()
        drifted = 0.0 if self.weather == "clear" else float((moment - EPOCH) / np.timedelta64(1, "s"))
        return Sky(
            sun_azimuth=azimuth,
            sun_elevation=elevation,
            clouds=weather_clouds(self.weather, self.cloud_seed, self.wind),
            time=drifted,
            **settings,
        )


def first_moment(light: LightParams) -> np.datetime64:
    """Date and time as datetime64 in UTC.

    Raises
    ------
    InputError
        If date or time cannot be read.
    """
    try:
        given = datetime.fromisoformat(f"{light.date}T{light.time}")
    except ValueError:
        raise InputError(
            f"date and time are {quoted(light.date)} and {quoted(light.time)}, expected them as 2014-04-11 and 09:30, "
            "09:30Z or 09:30+01:00"
        ) from None
    if given.tzinfo is not None:
        return _moment(given)
    east_of_greenwich = np.timedelta64(round(light.longitude_deg * 240e6), "us")  # a turn is a day
    return _moment(given.replace(tzinfo=UTC)) - east_of_greenwich


def _moment(time: datetime) -> np.datetime64:
    return cast(np.datetime64, utc(time)[()])
