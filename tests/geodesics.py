"""Where a geodesic on the ellipsoid leads: Vincenty (Survey Review 1975, direct formula), apart from what is tested."""

from math import atan, atan2, cos, degrees, hypot, radians, sin, tan

WGS84 = (6378137.0, 1 / 298.257223563)


def destination(latitude_deg, longitude_deg, bearing, length, ellipsoid=WGS84):
    """Latitude and longitude [deg] after `length` metres along `bearing` [rad]."""
    a, f = ellipsoid
    b = a * (1 - f)
    reduced = atan((1 - f) * tan(radians(latitude_deg)))
    sigma1 = atan2(tan(reduced), cos(bearing))
    sin_alpha = cos(reduced) * sin(bearing)
    cos2_alpha = 1 - sin_alpha**2
    u2 = cos2_alpha * (a**2 - b**2) / b**2
    big_a = 1 + u2 / 16384 * (4096 + u2 * (-768 + u2 * (320 - 175 * u2)))
    big_b = u2 / 1024 * (256 + u2 * (-128 + u2 * (74 - 47 * u2)))
    sigma = length / (b * big_a)
    for _ in range(30):
        middle = cos(2 * sigma1 + sigma)
        inner = cos(sigma) * (2 * middle**2 - 1)
        inner -= big_b / 6 * middle * (4 * sin(sigma) ** 2 - 3) * (4 * middle**2 - 3)
        sigma = length / (b * big_a) + big_b * sin(sigma) * (middle + big_b / 4 * inner)
    middle = cos(2 * sigma1 + sigma)
    across = sin(reduced) * sin(sigma) - cos(reduced) * cos(sigma) * cos(bearing)
    along = sin(reduced) * cos(sigma) + cos(reduced) * sin(sigma) * cos(bearing)
    latitude = atan2(along, (1 - f) * hypot(sin_alpha, across))
    turn = atan2(sin(sigma) * sin(bearing), cos(reduced) * cos(sigma) - sin(reduced) * sin(sigma) * cos(bearing))
    c = f / 16 * cos2_alpha * (4 + f * (4 - 3 * cos2_alpha))
    outer = middle + c * cos(sigma) * (2 * middle**2 - 1)
    turn -= (1 - c) * f * sin_alpha * (sigma + c * sin(sigma) * outer)
    return degrees(latitude), longitude_deg + degrees(turn)
