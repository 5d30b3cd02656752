"""Evidence for each candidate: residual over the noise at rest, and status in the choice."""

import pandas as pd

from freerock.figures import style
from freerock.figures.style import Drawing, Labels, Style, printed
from freerock.models.laws import CANDIDATES, MODEL_LABELS

FIGURE = {
    "title": "Evidence for each candidate law",
    "caption": "For each run and candidate: power of the residual over that of the noise at rest, in the "
    "most significant frequency band; 1 (dotted) is noise. Symbols show the result of the choice.",
    "reads": ["choice"],
}

HOLLOW: Style = {"markerfacecolor": "none"}
LOOKS: dict[str, Style] = {
    "selected": {"marker": "o", "color": "black", "markersize": 5, "label": "named"},
    "also_possible": {"marker": "s", "color": "#0072b2", "markersize": 4.5, "label": "also possible"}
    | HOLLOW,
    "rejected": {"marker": "x", "color": "#d55e00", "markersize": 4.5, "label": "rejected"},
}
LOOKS["nearest"] = LOOKS["selected"] | HOLLOW | {"label": "nearest, explains no run"}


@printed
def draw(choice: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """Power of the residual over that of the noise at rest, run by run and candidate by candidate.

    Parameters
    ----------
    choice : pandas.DataFrame
        Tidy table; candidates that were not fitted have no number and are left out.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of the table choice.
    """
    data = choice[choice["noise_ratio"].notna() & choice["status"].isin(LOOKS)]
    if data.empty:
        return style.nothing_drawn("no candidate was fitted", origin), data
    shown = [model for model in CANDIDATES if model in set(data["model"])]
    figure, panels = style.panel_per_scene(
        style.scenes_in(data), labels, 0.9 + 0.22 * max(3, len(shown)), sharex=True, sharey=True
    )
    for (block, foundation), ax in panels.items():
        scene = style.of_scene(data, block, foundation)
        ax.axvline(1, color="0.3", linestyle=":", label="as the noise at rest")
        nearest = (scene["status"] == "selected") & ~scene["explains"].astype(bool)
        kinds = scene["status"].mask(nearest, "nearest")
        for kind, look in LOOKS.items():
            own = scene[kinds == kind]
            places = [shown.index(model) for model in own["model"]]
            if places:
                ax.plot(own["noise_ratio"], places, linestyle="", **style.sized(look))
        ax.margins(x=0.05)
    first = next(iter(panels.values()))
    first.set(xscale="log", ylim=(len(shown) - 0.5, -0.5))
    first.set_yticks(range(len(shown)), [MODEL_LABELS[model] for model in shown])
    style.outer_labels(panels, "power of the residual over that at rest / 1", "")
    style.finish(figure, origin)
    return figure, data


caption = style.runs_counted
