"""Numbers and units as text: rounded by their uncertainty, with powers of ten and true signs."""

import math
import re
from collections.abc import Sequence

SIMULATED_NOTE = "The records are simulated; they are not the laboratory's data."
LEAST_PERCENT = 0.01  # of an ε_θ that is told
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def quantity(value: float, stderr: float = math.nan, digits: int = 3) -> str:
    """A value rounded by its uncertainty, with a power of ten where it is large or small.

    Parameters
    ----------
    value : float
        The value.
    stderr : float, optional
        Its standard error, printed with two significant digits; without one the value has `digits` of them.
    digits : int
        Significant digits of a value without a standard error.

    Returns
    -------
    str
        For instance "0.9570 ± 0.0012", "(6.880 ± 0.012)·10⁶", "6.88·10⁶"; "–" for NaN.
    """
    if not math.isfinite(value):
        return "–"
    magnitude = _exponent(value, digits)
    known = math.isfinite(stderr) and stderr > 0
    most = 4 if known else max(3, digits)  # digits before the decimal point
    coarse = known and magnitude > 1 and stderr >= 99.5  # two of its digits end before the decimal point
    larger = max(magnitude, _exponent(stderr, 2)) if known else magnitude  # a value may be near zero
    power = magnitude if coarse or not -3 <= larger < most else 0
    decimals = max(0, 1 - _exponent(stderr, 2) + power if known else digits - 1 - magnitude + power)
    text = fixed(value / 10.0**power, decimals)
    if not float(text.replace("−", "-")):
        text = text.lstrip("−")
    if known:
        text = f"{text} ± {stderr / 10.0**power:.{decimals}f}"
    if power:
        text = f"({text})" if known else text
        text += "·10" + str(power).translate(SUPERSCRIPTS)
    return text


def percent(fraction: float, digits: int = 2) -> str:
    """A share in per cent, a bound where it is too small to matter: "15", "< 0.01"; "–" for NaN."""
    return f"< {LEAST_PERCENT}" if 100 * fraction < LEAST_PERCENT else quantity(100 * fraction, digits=digits)


def fixed(value: float, decimals: int) -> str:
    """A number with so many decimals and a true minus sign; "–" for NaN."""
    return f"{value:.{decimals}f}".replace("-", "−") if math.isfinite(value) else "–"


def with_unit(symbol: str, unit: str) -> str:
    """Symbol and unit, "k / (N m⁻²)" or "t₀ / s"; the symbol alone for a pure number."""
    text = unit_text(unit)
    return f"{symbol} / ({text})" if " " in text else f"{symbol} / {text}" if text else symbol


def unit_text(unit: str) -> str:
    """A unit with raised exponents, "N m⁻²"; nothing for a pure number."""
    if unit == "1":
        return ""
    return re.sub(r"-[0-9]", lambda exponent: exponent[0].translate(SUPERSCRIPTS), unit)


def value_text(value: float, stderr: float, unit: str) -> str:
    """A value with its error and unit: "(6.880 ± 0.012)·10⁶ N m⁻²"; angles in degrees: "5.790 ± 0.010°"."""
    if unit == "rad":
        return f"{quantity(math.degrees(value), math.degrees(stderr))}°"
    return f"{quantity(value, stderr)} {unit_text(unit)}".rstrip()


def in_words(names: Sequence[str]) -> str:
    """Names one after the other: "a, b and c"."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _exponent(value: float, digits: int) -> int:
    return int(f"{value:.{digits - 1}e}".split("e")[1]) if value else 0
