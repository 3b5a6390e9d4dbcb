"""Zernike polynomials from their definition (Born & Wolf, Principles of Optics, section 9.2.1), in whole numbers."""

from fractions import Fraction
from math import factorial


def coefficient(n: int, m: int, power: int) -> int:
    """Factor of r^power in R_nm."""
    k = (n - power) // 2
    return (-1) ** k * factorial(n - k) // (factorial(k) * factorial((n + m) // 2 - k) * factorial((n - m) // 2 - k))


def radial_value(n: int, m: int, radius: Fraction) -> Fraction:
    """R_nm at a radius."""
    return sum((coefficient(n, m, power) * radius**power for power in range(m, n + 1, 2)), Fraction(0))


def radial_integral(n: int, m: int, low: Fraction, high: Fraction) -> Fraction:
    """Integral of R_nm r dr between two radii."""
    return sum(
        (
            coefficient(n, m, power) * (high ** (power + 2) - low ** (power + 2)) / (power + 2)
            for power in range(m, n + 1, 2)
        ),
        Fraction(0),
    )
