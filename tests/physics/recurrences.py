"""Writes `freerock.models.series_sums`: the recurrences of `series`, order by order.

python tests/physics/recurrences.py
"""

from collections.abc import Sequence
from pathlib import Path

from freerock import models

ORDER = 10  # of the series
HEAD = f'''"""Sums of the Taylor series of `series`, order by order.

Written by `python tests/physics/recurrences.py`: change that file, not this one.
"""

from freerock.models.compiled import compiled

ORDER = {ORDER}
FAST = {{"contract", "reassoc", "nsz"}}  # of floating-point arithmetic; NaN and infinity stay what they are

# fmt: off
'''
FILLS = {"corner": "on_corner", "whole": "on_whole_base", "air": "in_air"}
COMPILED = "@compiled(fastmath=FAST, forceinline=True)\n"


def _sum(terms: Sequence[str]) -> str:
    """From the left, so that what is known last is added last."""
    found = terms[0]
    for term in terms[1:]:
        found = f"({found} + {term})"
    return found


def _product(x: str, y: str, n: int, first: int = 0) -> str:
    """Coefficient n of the product of two series; of the first series from a coefficient on."""
    return _sum([f"{x}{j}*{y}{n - j}" for j in sorted(range(first, n + 1), key=lambda j: max(j, n - j))])


def _square(x: str, n: int) -> str:
    """Coefficient n of the square of a series."""
    twice = [f"2.0*{x}{j}*{x}{n - j}" for j in range((n - 1) // 2, -1, -1)]
    return _sum([f"{x}{n // 2}*{x}{n // 2}", *twice] if n % 2 == 0 else twice)


FIRST = {
    "all": ("z1, t1 = v0, w0", "lever = h*c0 + a*s0", "by_inertia = 1 / (J + lever*lever)"),
    "corner": (
        "by_slope = 1 / s0",
        "d0 = z0 + h*c0 + b*s0",
        "l0 = d0*by_slope",
        "a0 = d0*l0",
        "al0, da0, aa0 = a0*l0, d0*a0, a0*a0",
    ),
    "whole": ("y0 = z0 + h*c0", "third = b*b*b / 3"),
}


def _contact(touching: str, n: int) -> list[str]:
    """Force f_n, and e_n = -M_n, of the series up to order n + 1."""
    m = n + 1
    if touching == "corner":
        return [
            f"d{m} = z{m} + h*c{m} + b*s{m}",
            f"l{m} = (d{m} - {_product('s', 'l', m, 1)})*by_slope",
            f"a{m} = {_product('d', 'l', m)}",
            f"al{m} = {_product('a', 'l', m)}",
            f"da{m} = {_product('d', 'a', m)}",
            f"aa{m} = {_square('a', m)}",
            f"f{n} = k*(1/2)*a{n} + {m}.0*(c*(1/2)*a{m} + lam*(1/6)*da{m})",
            f"e{n} = k*(1/6)*al{n} + {m}.0*(c*(1/6)*al{m} + lam*(1/24)*aa{m}) - b*f{n}",
        ]
    if touching == "whole":
        return [
            f"y{m} = z{m} + h*c{m}",
            f"yy{m} = {_square('y', m)}",
            f"ss{m} = {_square('s', m)}",
            f"ys{m} = {_product('y', 's', m)}",
            f"f{n} = 2.0*b*k*y{n} + {m}.0*(2.0*b*c*y{m} + lam*(b*yy{m} + third*ss{m}))",
            f"e{n} = -2.0*third*(k*s{n} + {m}.0*(c*s{m} + lam*ys{m}))",
        ]
    return [f"f{n} = 0.0", f"e{n} = 0.0"]


def _written_out(touching: str) -> str:
    """Text of the function that fills the coefficients of Z and θ from their values and rates."""
    lines = [*FIRST["all"], *FIRST.get(touching, ())]
    for n in range(ORDER - 1):
        m = n + 1
        # cw and sw hold the sums for cos θ θ̇ and sin θ θ̇, but for their newest term
        known_c, known_s = (f"cw{n} + ", f"sw{n} + ") if n else ("", "")
        lines += [f"s{m} = ({known_c}c0*w{n})*(1/{m})", f"c{m} = -({known_s}s0*w{n})*(1/{m})"]
        lines += _contact(touching, n)
        gravity = "g - " if n == 0 else "-"
        lines += [
            f"z{n + 2} = ({gravity}f{n})*(1/{(n + 1) * (n + 2)})",
            f"cw{m} = {_product('c', 'w', m, 1)}",
            f"sw{m} = {_product('s', 'w', m, 1)}",
            # what acts along sin θ and along cos θ, with ẍ_G - ẍ_g but for its newest term
            f"x{m} = {m}.0*(h*cw{m} + a*sw{m}){' - ground' if n == 0 else ''}",
            f"f{n} = h*f{n} - a*x{m}",
            f"e{n} = e{n} - h*x{m}",
        ]
        turning = [
            *([_product("s", "f", n, 1), _product("c", "e", n, 1)] if n else []),
            f"s0*f{n}",
            f"c0*e{n}",
        ]
        lines += [
            f"w{m} = {_sum(turning)}*(by_inertia*(1/{m}))",
            f"t{n + 2} = w{m}*(1/{n + 2})",
            f"f{n} = f{n} - a*lever*{m}.0*w{m}",
            f"e{n} = e{n} - h*lever*{m}.0*w{m}",
        ]
    lines += [f"z[{n}], t[{n}] = z{n}, t{n}" for n in range(ORDER + 1)]
    head = f"def {FILLS[touching]}(z, t, z0, v0, t0, w0, s0, c0, a, law):\n"
    lines.insert(0, "k, c, lam, b, h, J, g, ground = law")
    return head + "".join(f"    {line}\n" for line in lines)


def _horner() -> str:
    """Value of the polynomial of the coefficients p0, p1 and so on at x."""
    found = f"p{ORDER}"
    for n in range(ORDER - 1, -1, -1):
        found = f"({found}*x + p{n})"
    return found


def _both_at() -> str:
    """Text of the function that gives both polynomials and their rates."""
    lines = [f"a, b, v, w = z[{ORDER}], t[{ORDER}], 0.0, 0.0"]
    lines += [f"v, w, a, b = v*x + a, w*x + b, a*x + z[{n}], b*x + t[{n}]" for n in range(ORDER - 1, -1, -1)]
    return "def both_at(z, t, x):\n" + "".join(f"    {line}\n" for line in [*lines, "return a, v, b, w"])


def _fill_theta() -> str:
    """Text of the function that samples θ: a plain loop over slices, which becomes one of vectors."""
    names = ", ".join(f"p{n}" for n in range(ORDER + 1))
    values = ", ".join(f"sign*p[{n}]" for n in range(ORDER + 1))
    lines = [f"{names} = {values}", "for i in range(time.size):", "    x = time[i] - start"]
    lines.append(f"    theta[i] = {_horner()}")
    return "def fill_theta(p, sign, start, time, theta):\n" + "".join(f"    {line}\n" for line in lines)


def written() -> str:
    """Text of `series_sums`."""
    functions = [*map(_written_out, FILLS), _both_at(), _fill_theta()]
    return "\n\n\n".join([HEAD.rstrip(), *(COMPILED + function.rstrip() for function in functions)]) + "\n"


if __name__ == "__main__":
    Path(models.__file__).with_name("series_sums.py").write_text(written(), encoding="utf-8")
