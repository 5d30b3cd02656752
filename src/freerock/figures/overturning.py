"""Probability that a block overturns against the intensity of the ground motion."""

import math

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from freerock.figures import style
from freerock.figures.by_block import foundation_looks
from freerock.figures.style import Axes, Drawing, Labels, Style, printed
from freerock.records.channels import names_in_short
from freerock.response.motions import INTENSITIES

FIGURE = {
    "title": "Probability of overturning",
    "caption": "Share of the responses in which the block overturns, against peak acceleration and peak "
    "velocity of the ground. Symbols: counted in groups of equal size, with Wilson's 95 % interval "
    "for the number of motions. Lines: lognormal curve of maximum likelihood; band: 95 % of resampled "
    "motions (Baker 2015).",
    "reading": "The curve crosses one half at the median intensity. A wide band means few motions, or an "
    "intensity that hardly predicts overturning. The law was identified in free rocking; the figure does "
    "not show that it holds under a shaking base.",
    "reads": ["fragility"],
}


@printed
def draw(fragility: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """A row of panels for each block, a panel for each intensity, a curve for each record's law.

    Parameters
    ----------
    fragility : pandas.DataFrame
        Table of the campaign.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        The table, whose rows without a curve are not drawn.
    """
    curves = fragility[~fragility["kind"].isin(["none", "no_law"])]
    if curves.empty:
        why = "no ensemble has a curve: blocks always or never overturn, or no law explains their runs"
        return style.nothing_drawn(why, origin), fragility
    names, looks = list(dict.fromkeys(curves["block"])), foundation_looks(curves)
    figure = Figure(figsize=style.size(0.7 + 1.9 * len(names)))
    axes = figure.subplots(len(names), len(INTENSITIES), squeeze=False, sharey=True)
    for i, name in enumerate(names):
        for j, (measure, text) in enumerate(INTENSITIES.items()):
            ax, own = axes[i, j], curves[(curves["block"] == name) & (curves["measure"] == measure)]
            for (_, foundation), scene in own.groupby(["test", "foundation"], sort=False):
                _curve(ax, scene, looks[foundation], style.label(labels, foundation))
            style.entitle(ax, 2 * i + j, 2 * len(names), style.label(labels, name), 0.4)
            ax.set(xlabel=text, ylim=(-0.02, 1.02))
            ax.margins(x=0.04)
        axes[i, 0].set_ylabel("P(overturning)")
    style.finish(figure, origin)
    return figure, fragility


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """How many motions, how many responses failed, and of which records no law is known."""
    told, lawless = [], data.loc[data["kind"] == "no_law", "test"]
    if len(lawless) < len(data):
        told.append(f"{style.number_of(int(data['n_motions'].max()), 'ground motion').capitalize()}.")
    if failed := int(data.drop_duplicates("test")["n_failed"].sum()):
        told.append(f"{style.number_of(failed, 'response').capitalize()} left out: the integration failed.")
    if len(lawless):
        told.append(f"Not known, as no law explains the runs or no run is usable: {names_in_short(lawless)}.")
    return " ".join(told)


def _curve(ax: Axes, scene: pd.DataFrame, look: Style, name: str) -> None:
    """The fitted curve with its band, and the counted shares."""
    line, counted = scene[scene["kind"] == "fitted"], scene[scene["kind"] == "counted"]
    drawn = {key: value for key, value in look.items() if key != "marker"}
    ax.plot(line["intensity"], line["probability"], label=name, **drawn)
    if line["low"].notna().any():
        band = {"color": look.get("color"), "alpha": 0.18, "lw": 0}
        ax.fill_between(line["intensity"], line["low"], line["high"], **band)
    below, above = counted["probability"] - counted["low"], counted["high"] - counted["probability"]
    bars = [below.clip(lower=0.0), above.clip(lower=0.0)]
    dots = {"linestyle": "", "marker": look.get("marker"), "color": look.get("color"), "markersize": 3.5}
    ax.errorbar(counted["intensity"], counted["probability"], yerr=bars, elinewidth=0.7, **dots)
    if not math.isclose(scene["intensity"].max(), scene["intensity"].min()):
        ax.set_xscale("log")
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0, 7.0)))
        ax.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
