"""The set-up as it is configured: each block with its beams, to scale."""

from collections.abc import Mapping
from math import degrees
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Rectangle

from freerock.figures import style
from freerock.figures.style import Axes, Drawing, Labels, Style, styled
from freerock.models.block import Block

BEAM: Style = {"color": "#b34700", "arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0}
MOST_BESIDE, NARROWEST_IN = 4, 1.7  # panels, and each of them


@styled()
def draw(
    blocks: Mapping[str, Block], set_ups: Mapping[str, Mapping[str, Any]], origin: str, labels: Labels = None
) -> Drawing:
    """A panel for each block, with the beams that meet it and the foundations it stands on.

    Parameters
    ----------
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.
    set_ups : mapping
        By block, foundations (names) and lasers (mappings with name, beam, position_m, face), as of the
        records.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        A row per block and laser: sizes, R, θ_cr, beam and its place, foundations.
    """
    rows = -(-len(set_ups) // style.fit_beside(min(len(set_ups), MOST_BESIDE), NARROWEST_IN))
    beside = -(-len(set_ups) // rows)
    shown = {name: blocks[name] for name in set_ups}
    heights = [each.height_m for each in shown.values()]
    tallest, widest = max(heights), max(each.width_m for each in shown.values())
    low = 0.2 * tallest
    high = [1.12 * max(heights[i * beside : (i + 1) * beside]) for i in range(rows)]
    room = [(low + each) / (1.32 * tallest) for each in high]
    figure = Figure(figsize=(style.WIDTH_IN, 0.2 + 0.3 * rows + 2.3 * sum(room)))
    axes = figure.subplots(rows, beside, squeeze=False, height_ratios=room)  # one scale for all
    for i, (ax, (name, block)) in enumerate(zip(axes.ravel(), shown.items(), strict=False)):
        _panel(ax, block, set_ups[name], labels)
        half = max(1.6 * widest, 0.42 * tallest)
        ax.set(xlim=(-half, half), ylim=(-low, high[i // beside]), aspect="equal")
        style.entitle(ax, i, len(shown), style.label(labels, name), 0.8 / beside)
    for ax in axes.ravel():
        ax.set_axis_off()
    style.footer(figure, origin)
    return figure, pd.DataFrame(_rows(shown, set_ups))


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """What an arrow is, where there is one."""
    arrows = "Arrows: beams of sensors, with their height above the base, or distance right of its centre."
    return arrows if data["beam"].any() else ""


def _panel(ax: Axes, block: Block, set_up: Mapping[str, Any], labels: Labels) -> None:
    b, h, height = block.width_m / 2, block.h, block.height_m
    outline: Style = {"facecolor": "0.93", "edgecolor": "black", "linewidth": 0.9}
    ax.add_patch(Rectangle((-b, 0), 2 * b, height, **outline))
    ground: Style = {"facecolor": "none", "edgecolor": "0.55", "hatch": "////", "linewidth": 0}
    half, depth = 2.4 * b, 0.25 * b + 0.02 * height
    ax.add_patch(Rectangle((-half, -depth), 2 * half, depth, **ground))
    ax.plot([-half, half], [0, 0], color="black", linewidth=0.9)
    ax.plot(block.e, h, "+", color="black", markersize=6)
    side = -1 if block.e < 0 else 1  # of the corner nearer to the centre of mass
    corner = side * block.b
    ax.plot([block.e, corner], [h, 0], color="#0a5bd3", linewidth=0.8)
    ax.plot([corner] * 2, [0, 1.05 * h], color="#0a5bd3", linewidth=0.6, linestyle=":")
    turn = degrees(block.theta_cr)
    span = (90, 90 + turn) if side > 0 else (90 - turn, 90)
    ax.add_patch(Arc((corner, 0), 1.3 * h, 1.3 * h, theta1=span[0], theta2=span[1], color="#0a5bd3"))
    small: Style = {"color": "#0a5bd3"}
    ax.text(corner + side * 0.12 * b, 0.62 * h, "$θ_{cr}$", ha="left" if side > 0 else "right", **small)
    ax.text(block.e + side * 0.35 * b, 0.35 * h, "R", ha="right" if side > 0 else "left", **small)
    size_mm = f"{1e3 * block.width_m:.4g} × {1e3 * height:.4g} mm"
    stands = style.label(labels, *set_up["foundations"])
    ax.text(0, -1.3 * depth, f"{size_mm}\non {stands}", ha="center", va="top")
    for laser in set_up["lasers"]:
        _beam(ax, block, laser)


def _beam(ax: Axes, block: Block, laser: Mapping[str, Any]) -> None:
    """The beam of a sensor with its place; a sensor of the rotation itself has none."""
    if laser["beam"] is None:
        return
    at, b, top = laser["position_m"], block.width_m / 2, block.height_m
    if laser["beam"] == "horizontal":
        side, towards = (-1, "right") if laser["face"] == "left" else (1, "left")
        head, tail = (side * b, at), (side * 2.6 * b, at)
        place: Style = {"x": side * 1.2 * b, "y": at + 0.1 * b, "va": "bottom", "ha": towards}
    else:
        head, tail = (at, top), (at, 1.1 * top)
        place = {"x": at + 0.1 * b, "y": 1.1 * top, "va": "top"}
    ax.annotate("", head, tail, arrowprops=BEAM)
    ax.text(s=f"{1e3 * at:.4g} mm", **place)


def _rows(blocks: Mapping[str, Block], set_ups: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    return [
        {
            "block": name,
            "height_m": block.height_m,
            "width_m": block.width_m,
            "R_m": block.R,
            "theta_cr_deg": degrees(block.theta_cr),
            "laser": laser["name"],
            "beam": laser["beam"] or "",
            "position_m": laser["position_m"],
            "foundations": " ".join(set_ups[name]["foundations"]),
        }
        for name, block in blocks.items()
        for laser in set_ups[name]["lasers"]
    ]
