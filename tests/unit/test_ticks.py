"""Ticks drawn as few artists: where Matplotlib's own are, with the same numbers, none of which says less."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from freerock.figures import style, ticks


def panels(low, high, **axes):
    figure = Figure(figsize=(6, 4), dpi=100, layout="none")
    for ax in figure.subplots(2):
        ax.plot([0, 7], [low, high])
        ax.set(xlim=(0, 7), ylim=(low, high), **axes)
    figure.axes[0].tick_params(labelbottom=False)
    return figure


def numbers(figure):
    """The numbers drawn, with their places [dots]."""
    figure.draw_without_rendering()
    texts = [text for ax in figure.axes for text in ax.texts]
    for ax in figure.axes:
        for n, axis in enumerate((ax.xaxis, ax.yaxis)):
            low, high = axis.get_view_interval()
            labels = [label for label in axis.get_ticklabels() if low <= label.get_position()[n] <= high]
            texts += [label for label in labels if label.get_visible()]
    return {(text.get_text(), *np.round(text.get_window_extent().p0).tolist()) for text in texts}


SPANS = [(-4, 9, "linear"), (0.3, 2.7, "linear"), (-50, 20, "symlog")]


@pytest.mark.parametrize(("low", "high", "scale"), SPANS)
@style.styled()
def test_numbers_are_matplotlibs_at_its_places(low, high, scale):
    own, light = (panels(low, high, yscale=scale) for _ in range(2))
    ticks.lighten(light)
    assert len(numbers(own)) > 10
    assert numbers(light) == numbers(own)
    assert not any(len(ax.get_xticks()) or len(ax.get_yticks()) for ax in light.axes)


@style.styled()
def test_the_grid_ends_at_the_panel_and_ticks_stand_outside():
    figure = panels(-4, 9)
    at = [(ax.get_xticks(), [tick for tick in ax.get_yticks() if -4 <= tick <= 9]) for ax in figure.axes]
    ticks.lighten(figure)
    grid, marks = figure.artists
    assert len(grid.get_segments()) == len(marks.get_segments()) == sum(len(x) + len(y) for x, y in at)
    inches = figure.transFigure - figure.dpi_scale_trans
    boxes = [ax.get_position().transformed(inches) for ax in figure.axes]
    for start, end in grid.get_segments():
        assert any(box.padded(1e-9).contains(*start) and box.padded(1e-9).contains(*end) for box in boxes)
    for start, end in marks.get_segments():
        assert np.hypot(*(end - start)) == pytest.approx(3.5 / 72)
        assert not any(box.contains(*end) for box in boxes)


@pytest.mark.parametrize(("low", "high"), [(1e-5, 4e-5), (5.0001, 5.0009), (2e7, 9e7)])
@style.styled()
def test_no_number_hides_a_power_or_an_offset(low, high):
    """Matplotlib writes them beside the axis, where a page has no room for them."""
    figure = panels(low, high)
    ticks.lighten(figure)
    written = [float(text.get_text()) for text in figure.axes[0].texts]
    assert len(written) > 2 and all(low <= number <= high for number in written)
    assert len(set(written)) == len(written)
