"""Draws the figures of docs/physics.md: `python docs/images/draw.py [FOLDER]`."""

import math
import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon
from scipy.integrate import quad

from freerock.figures.style import styled
from freerock.files import atomic
from freerock.models.block import GRAVITY
from freerock.models.block_on_bed import State
from freerock.models.housner import housner_motion, housner_swings
from freerock.models.laws import Foundation, Rules
from freerock.models.simulate import simulate
from freerock.virtual_lab import published

sys.path.insert(0, str(Path(__file__).parents[2] / "tests/physics"))
from plain_law import contact_intervals

BLOCKS, RELEASE = (
    dict(enumerate(values.values(), 1)) for values in (published.BLOCKS, published.RELEASE_ANGLES)
)
WINKLER_MARBLE, HUNT_CROSSLEY_MARBLE = (
    published.TABLE_2["marble"][law] for law in ("winkler", "hunt_crossley")
)
BLUE, RED, GREY = "#0072b2", "#d55e00", "0.45"
STONE, GROUND = "#f2ede4", "0.88"
LINES = {"geometric": "-", "tensionless": "--"}


def rigid_limit(block, theta0):
    """Instant of the first impact [s] of eq. (1) on an infinitely stiff foundation."""
    inertia, potential = guided_inertia(block), GRAVITY * block.R

    def slowness(x):
        theta = theta0 * (1 - x * x)
        fall = potential * (math.cos(block.theta_cr - theta0) - math.cos(block.theta_cr - theta))
        return 2 * theta0 * x * math.sqrt(inertia(theta) / (2 * fall))

    return quad(slowness, 0, 1, epsabs=1e-12)[0]


def guided_inertia(block):
    """Inertia over mass [m²] of a block that turns about a corner, its base centre on a vertical line."""
    i_cm, b, h = block.inertia_cm / block.mass_kg, block.b, block.h
    return lambda theta: i_cm + h**2 + (b * math.cos(theta)) ** 2 - b * h * math.sin(2 * abs(theta))


def arrow(ax, tail, head, color="black", style="-|>", width=0.9):
    properties = {"arrowstyle": style, "color": color, "linewidth": width, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", head, tail, arrowprops=properties)


def blank(ax, x, y, title):
    ax.set(xlim=x, ylim=y, aspect="equal")
    ax.axis("off")
    ax.set_title(title, loc="left")


def turned(theta, base_centre):
    """The point u to the right of the base centre along the base and v above it along the axis, as (x, y)."""
    s, c = math.sin(theta), math.cos(theta)
    return lambda u, v: (base_centre[0] + u * c + v * s, base_centre[1] - u * s + v * c)


def free_body():
    theta, b, h, depth = math.radians(14), 1.0, 2.0, 0.11
    at = turned(theta, (0.0, -depth))
    s = math.sin(theta)
    u0 = -depth / s
    figure = Figure(figsize=(7.2, 3.9))
    axes = figure.subplots(1, 2)
    for ax, title in zip(axes, ("(a) geometry and signs", "(b) what acts on the block"), strict=True):
        blank(ax, (-2.3, 2.6), (-0.95, 4.35), title)
        surface = [(-2.3, 0), at(u0, 0), at(b, 0), (at(b, 0)[0], 0), (2.6, 0), (2.6, -0.75), (-2.3, -0.75)]
        ax.add_patch(Polygon(surface, facecolor=GROUND, edgecolor="none"))
        ax.plot(*np.transpose(surface[:5]), color=GREY, linewidth=0.8)
        ax.plot([-2.3, 2.6], [0, 0], color=GREY, linewidth=0.6, linestyle=":")
        corners = [at(-b, 0), at(b, 0), at(b, 2 * h), at(-b, 2 * h)]
        ax.add_patch(Polygon(corners, facecolor=STONE, edgecolor="black", linewidth=1.0))
        for point in (at(0, 0), at(0, h)):
            ax.plot(*point, "ko", markersize=3)

    geometry_and_signs(axes[0], at, b, h, theta, depth)
    what_acts(axes[1], at, b, h, u0, depth, s)
    return figure


def geometry_and_signs(ax, at, b, h, theta, depth):
    ax.plot(*np.transpose([at(0, 0), at(0, 2 * h)]), color=GREY, linewidth=0.6, linestyle="-.")
    ax.plot([0, 0], [-depth, 3.0], color=GREY, linewidth=0.6, linestyle="-.")
    ax.add_patch(Arc((0, -depth), 5.6, 5.6, theta1=90 - math.degrees(theta), theta2=90, color=BLUE))
    arrow(ax, (0.52, 2.64), (0.66, 2.61), BLUE)
    ax.text(0.36, 2.86, "θ > 0", color=BLUE, ha="center")
    ax.text(at(0, h)[0] + 0.12, at(0, h)[1], "cm")
    ax.text(at(0, 0)[0] - 0.02, -depth + 0.1, "cb", ha="right")
    for (start, end), text, offset in (
        (((0, 4.18), (b, 4.18)), "b", 0.13),
        (((-b, 4.18), (0, 4.18)), "b", 0.13),
    ):
        arrow(ax, at(*start), at(*end), style="<|-|>", width=0.6)
        middle = at((start[0] + end[0]) / 2, start[1] + offset)
        ax.text(*middle, text, ha="center", va="center")
    for low, high in ((0, h), (h, 2 * h)):
        arrow(ax, at(-1.18, low), at(-1.18, high), style="<|-|>", width=0.6)
        ax.text(*at(-1.34, (low + high) / 2), "h", ha="center", va="center")
    arrow(ax, at(0, h), at(b, 0), GREY, style="-", width=0.6)
    ax.text(*at(0.62, 1.1), "R", color=GREY)
    arrow(ax, (-1.55, 0), (-1.55, -0.55), BLUE)
    ax.text(-1.63, -0.4, "z", color=BLUE, ha="right")
    ax.text(-2.25, 0.07, "z = 0", color=GREY)
    arrow(ax, at(0, -0.34), at(0.75, -0.34), BLUE)
    ax.text(*at(0.86, -0.4), "u", color=BLUE)
    ax.text(2.58, -0.24, "z(u) = z$_{cb}$ + u sin θ", color=BLUE, ha="right", fontsize=7)


def what_acts(ax, at, b, h, u0, depth, s):
    arrow(ax, at(0, h), (at(0, h)[0], at(0, h)[1] - 1.05))
    ax.text(at(0, h)[0] + 0.1, at(0, h)[1] - 1.0, "m g")
    for u in np.linspace(u0 + 0.12, b, 8):
        x, y = at(u, 0)
        arrow(ax, (x, y - 0.9 * (depth + u * s)), (x, y), RED, width=0.8)
    ax.text(1.2, -0.42, "f(u) per unit\nwidth of base", color=RED, va="center")
    ax.plot(*at(u0, 0), "o", color=RED, markersize=3)
    ax.text(at(u0, 0)[0] - 0.06, 0.09, "u$_0$", color=RED, ha="right")
    ax.text(1.12, 0.09, "u$_1$ = b", color=RED)
    arrow(ax, at(0, h), (at(0, h)[0] + 0.95, at(0, h)[1]), GREY)
    ax.text(at(0, h)[0] + 0.5, at(0, h)[1] + 0.1, "m ẍ$_g$", color=GREY)
    arrow(ax, (at(0, h)[0], at(0, h)[1] + 0.75), at(0, h), GREY)
    ax.text(at(0, h)[0] + 0.1, at(0, h)[1] + 0.55, "m z̈$_g$", color=GREY)
    arrow(ax, (-1.25, -0.45), (-1.95, -0.45), BLUE)
    ax.text(-1.6, -0.6, "ẍ$_g$ > 0", ha="center", va="top", color=BLUE)
    arrow(ax, (-2.15, -0.6), (-2.15, 0.1), BLUE)
    ax.text(-2.25, 0.18, "z̈$_g$ > 0", color=BLUE)


def contact_interval():
    block, k = BLOCKS[2], WINKLER_MARBLE["k"]
    c, lam = WINKLER_MARBLE["c"], HUNT_CROSSLEY_MARBLE["lambda"]
    # title, model's c and λ, z_cb, ż_cb, θ, θ̇
    states = (
        ("no uplift", 0.0, lam, 1.2e-3, 4e-3, math.radians(1.0), 0.1),
        ("uplift, θ > 0", 0.0, lam, 0.2e-3, 0.0, math.radians(2.0), 0.4),
        ("uplift, θ < 0", 0.0, lam, 0.2e-3, 0.0, math.radians(-2.0), -0.4),
        ("unloading", c, 0.0, 0.0, -0.15, math.radians(3.0), -1.0),
        ("flight", 0.0, lam, -1.6e-3, 0.0, math.radians(1.2), 0.0),
    )
    figure = Figure(figsize=(7.2, 3.2))
    axes = figure.subplots(2, len(states), sharex=True, sharey="row")
    u = np.linspace(-block.b, block.b, 71)
    for column, (title, c, lam, z, v, theta, w) in zip(axes.T, states, strict=True):
        depth, rate = z + u * math.sin(theta), v + u * w * math.cos(theta)
        whole = (k * depth + c * rate + lam * depth * rate) / 1e3
        foundation, state = Foundation(k, c, lam), State(z, v, theta, w)
        top, bottom = column
        top.set_title(title, loc="left")
        top.axhline(0, color=GREY, linewidth=0.8)
        top.plot(1e3 * u, 1e3 * depth, color="black", linewidth=1.4)
        top.fill_between(1e3 * u, 1e3 * np.maximum(depth, 0), 4, color=GROUND, linewidth=0)
        bottom.axhline(0, color=GREY, linewidth=0.8)
        for rule, color, level in (("geometric", BLUE, -14), ("tensionless", RED, -22)):
            for u0, u1 in contact_intervals(block, foundation, state, Rules(rule)):
                inside = np.clip(u, u0, u1)
                force = np.interp(inside, u, whole)
                if rule == "geometric":
                    bottom.fill_between(1e3 * inside, force, color=BLUE, alpha=0.2, linewidth=0)
                bottom.plot(1e3 * inside, force, color=color, linestyle=LINES[rule])
                bottom.plot([1e3 * u0, 1e3 * u1], [level, level], "|-", color=color, linewidth=1.6)
                for end, name in ((u0, "u$_0$"), (u1, "u$_1$")):
                    bottom.text(1e3 * end, level - 1.2, name, ha="center", va="top", fontsize=6)
        bottom.set(xlabel="u / mm", ylim=(-29, 30), xlim=(-44, 44))
    axes[0, 0].set(ylabel="depth z / mm", ylim=(3.6, -3.2))
    axes[1, 0].set_ylabel("f / (kN m⁻¹)")
    axes[1, -1].text(0, 8, "no contact", ha="center")
    axes[1, 0].text(0, -12.5, "geometric", color=BLUE, fontsize=6, ha="center")
    axes[1, 0].text(0, -20.5, "tensionless", color=RED, fontsize=6, ha="center")
    axes[1, 3].text(4, -7.5, "pull", color=BLUE, fontsize=7, ha="center")
    for ax, law in zip(axes[1, :4], 3 * ["Hunt–Crossley"] + ["Winkler"], strict=True):
        ax.text(0, 25, law, ha="center", fontsize=7)
    return figure


def housner():
    block, r, theta0 = BLOCKS[2], 0.958, RELEASE[2]
    swings = housner_swings(block, r, theta0)
    time = np.linspace(0, 8, 2001)
    theta, _ = housner_motion(swings, time, theta0)
    figure = Figure(figsize=(7.2, 2.6))
    left, right = figure.subplots(1, 2, width_ratios=(1.7, 1))
    left.plot(time, np.degrees(theta), color="black", linewidth=0.8)
    early = slice(0, 12)
    left.plot(swings.impact_time[early], np.zeros(12), "o", color=RED, label="impacts")
    left.plot(
        swings.peak_time[early],
        np.degrees(swings.sign * swings.peak)[early],
        "s",
        color=BLUE,
        label="peaks",
    )
    left.axvline(swings.rest_time, color=GREY, linestyle="--")
    left.text(swings.rest_time - 0.1, -6, f"rest at {swings.rest_time:.4f} s", ha="right", color=GREY)
    left.set(xlabel="t / s", ylabel="θ / °", xlim=(0, 8))
    left.legend(loc="upper center", ncols=2)
    time = np.linspace(0, swings.impact_time[5], 2001)
    theta, rate = housner_motion(swings, time, theta0)
    jump = np.flatnonzero(np.diff(np.sign(theta)) != 0) + 1
    right.plot(*(np.insert(np.degrees(a), jump, np.nan) for a in (theta, rate)), color="black")
    for n in range(5):
        before = -swings.sign[n] * np.degrees(swings.impact_rate[n])
        right.plot([0, 0], [before, r * before], color=RED, linewidth=1.6)
    right.set(xlabel="θ / °", ylabel="θ̇ / (° s⁻¹)")
    right.text(0, 0, "at an impact\nθ̇⁺ = r θ̇⁻", color=RED, ha="center", va="center")
    return figure


def debonding():
    block, theta0 = BLOCKS[2], RELEASE[2]
    time = np.linspace(0, 5, 1001)
    figure = Figure(figsize=(7.2, 2.4))
    axes = figure.subplots(1, 2, sharey=True)
    laws = (
        ("Hunt–Crossley", "hunt_crossley", HUNT_CROSSLEY_MARBLE),
        ("Winkler", "winkler", WINKLER_MARBLE),
    )
    for ax, (name, model, parameters) in zip(axes, laws, strict=True):
        for rule, color in (("geometric", BLUE), ("tensionless", RED)):
            response = simulate(model, block, parameters, time, theta0=theta0, rules=Rules(rule))
            ax.plot(time, np.degrees(response.theta), color=color, linestyle=LINES[rule], label=rule)
        ax.set_title(f"{name}, configuration 2 on marble (Table 2)", loc="left")
        ax.set_xlabel("t / s")
    axes[0].set_ylabel("θ / °")
    axes[1].legend(loc="upper right", ncols=2)
    return figure


def rigid():
    figure = Figure(figsize=(4.8, 2.8))
    ax = figure.subplots()
    stiffness = np.geomspace(1e7, 1e11, 13)
    for (number, block), color in zip(BLOCKS.items(), ("black", BLUE, RED), strict=True):
        theta0 = RELEASE[number]
        corner = housner_swings(block, 1.0, theta0, until=0.1).impact_time[0]
        for kinematics, line in (("pivoting", "s:"), ("guided", "o-")):
            rules = Rules(kinematics=kinematics)
            first = [
                simulate(
                    "hunt_crossley", block, {"k": k, "lambda": 19 * k}, [0, 0.5], theta0=theta0, rules=rules
                ).impacts[0]
                for k in stiffness
            ]
            late = 100 * (np.array(first) / corner - 1)
            ax.semilogx(stiffness, late, line, color=color, markerfacecolor="white" if "s" in line else color)
        ax.plot([], [], "o-", color=color, label=f"configuration {number}")
        ax.axhline(100 * (rigid_limit(block, theta0) / corner - 1), color=color, linestyle="--")
    ax.axhline(0, color=GREY)
    ax.text(9e10, -5.5, "circles: guided; dashed: its limit, k → ∞", ha="right", color=GREY)
    ax.text(9e10, 3.4, "squares: pivoting; grey: Housner", ha="right", color=GREY)
    ax.set(xlabel="k / (N m⁻²); λ/k = 19 s m⁻¹", ylabel="first impact, later than\nHousner's / %")
    ax.legend(loc="upper right")
    return figure


def laser():
    b, height, beam, theta = 1.0, 4.0, 2.6, math.radians(20)
    figure = Figure(figsize=(7.2, 3.3))
    axes = figure.subplots(1, 2)
    for ax, turn, title in (
        (axes[0], theta, "(a) θ > 0: about the right corner"),
        (axes[1], -theta, "(b) θ < 0: about the left corner"),
    ):
        blank(ax, (-3.4, 2.6), (-0.5, 4.6), title)
        pivot = b if turn > 0 else -b
        s, c = math.sin(turn), math.cos(turn)

        def at(x, y, pivot=pivot, s=s, c=c):
            return pivot + (x - pivot) * c + y * s, -(x - pivot) * s + y * c

        rest = [(-b, 0), (b, 0), (b, height), (-b, height)]
        ax.add_patch(Polygon(rest, facecolor="none", edgecolor=GREY, linewidth=0.6, linestyle="--"))
        ax.add_patch(Polygon([at(*p) for p in rest], facecolor=STONE, edgecolor="black"))
        ax.plot([-3.4, 2.6], [0, 0], color=GREY, linewidth=0.8)
        ax.plot(pivot, 0, "ko", markersize=4)
        t = math.tan(abs(turn))
        hit = b - 2 * b / c + beam * t if turn > 0 else -b - beam * t
        arrow(ax, (-3.3, beam), (hit, beam), RED, width=1.1)
        ax.text(-3.3, beam + 0.12, "beam", color=RED)
        ax.plot([-b, -b], [beam - 0.5, beam + 0.1], color=GREY, linewidth=0.6)
        ax.plot([hit, hit], [beam - 0.5, beam], color=RED, linewidth=0.6)
        arrow(ax, (-b, beam - 0.42), (hit, beam - 0.42), BLUE)
        ax.text((hit - b) / 2, beam - 0.5, "s", color=BLUE, ha="center", va="top")
        arrow(ax, (2.3, 0), (2.3, beam), style="<|-|>", width=0.6)
        ax.plot([hit, 2.4], [beam, beam], color=GREY, linewidth=0.5, linestyle=":")
        ax.text(2.37, beam / 2, "Y")
        ax.text(pivot, -0.12, "corner", ha="center", va="top")
        arrow(ax, (-3.0, -0.3), (-2.3, -0.3), BLUE)
        ax.text(-2.2, -0.38, "x, s > 0", color=BLUE)
    foot = b - 2 * b * math.cos(theta)
    arrow(axes[0], (foot, 0), (foot, 2 * b * math.sin(theta)), style="<|-|>", width=0.6)
    axes[0].text(-1.15, 0.34, "2b sin θ", ha="right", va="center")
    return figure


FIGURES = {
    "free_body": free_body,
    "contact_interval": contact_interval,
    "housner": housner,
    "debonding": debonding,
    "rigid_limit": rigid,
    "laser": laser,
}


@styled()
def draw(folder, names=FIGURES):
    """Write figures as SVG; the same bytes every time."""
    with matplotlib.rc_context({"svg.hashsalt": "freerock", "svg.fonttype": "path"}):
        for name in names:
            with atomic(Path(folder) / f"{name}.svg") as part:
                FIGURES[name]().savefig(part, format="svg", metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent)
