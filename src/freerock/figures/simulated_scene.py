"""θ(t) of a simulated scene."""

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures import looks, style
from freerock.figures.style import Drawing, styled

DIRECTIONS = {"ground_x_m_s2": "horizontal", "ground_z_m_s2": "vertical"}


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """θ(t) of each model, below the acceleration of the ground where it moves.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.virtual_lab.simulate_scene.simulate_scene`.
    """
    ground = [name for name in frame if name in DIRECTIONS and frame[name].any()]
    figure = Figure(figsize=(7.0, 2.6 + 1.4 * bool(ground)), layout="constrained")
    axes = figure.subplots(1 + bool(ground), 1, squeeze=False, sharex=True)[:, 0]
    for name in ground:
        axes[0].plot(frame["time_s"], frame[name], linewidth=0.8, label=DIRECTIONS[name])
        axes[0].set_ylabel("ground / (m/s²)")
        style.legend_above(axes[0])
    for model, look in looks.MODEL_STYLES.items():
        if f"theta_deg_{model}" in frame:
            axes[-1].plot(frame["time_s"], frame[f"theta_deg_{model}"], **look)
    axes[-1].set(xlabel="time / s", ylabel="θ / °")
    style.legend_above(axes[-1])
    style.footer(figure, "simulated")
    return figure, frame
