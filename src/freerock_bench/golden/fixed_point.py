"""Numbers in fixed point with 160 binary places, and power series of them.

A number is a Python integer, in units of 2**-160; a series is a list of them, the coefficients of the powers
of time in units of 2**-6 s.
"""

from fractions import Fraction
from operator import mul

PLACES = 160
ONE = 1 << PLACES
UNIT = 6  # the series' unit of time is 2**-UNIT s
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459")
Series = list[int]


def fixed(value: float | Fraction) -> int:
    """A number in fixed point."""
    exact = Fraction(value)
    return exact.numerator * ONE // exact.denominator


def number(value: int) -> float:
    """A number in fixed point as a float."""
    return float(Fraction(value, ONE))


def sine(angle: int) -> tuple[int, int]:
    """sin and cos of an angle [rad] by their series."""
    term, terms, n = ONE, [0, 0, 0, 0], 0
    while term:
        terms[n % 4] += term
        n += 1
        term = (term * angle >> PLACES) // n if term * angle >= 0 else -((-term * angle >> PLACES) // n)
    return terms[1] - terms[3], terms[0] - terms[2]


def product(a: Series, b: Series, n: int) -> int:
    """Coefficient n of a product."""
    total: int = sum(map(mul, a, b[n::-1]))
    return total >> PLACES


def quotient(a: Series, b: Series, c: Series, n: int) -> int:
    """Coefficient n of c = a/b, whose lower ones are known."""
    known: int = sum(map(mul, c, b[n:0:-1]))
    return ((a[n] << PLACES) - known) // b[0]


def at(series: Series, x: int) -> int:
    """Value of a series at a time."""
    value = 0
    for coefficient in reversed(series):
        value = (value * x >> PLACES) + coefficient
    return value
