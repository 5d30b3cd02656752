import inspect
from dataclasses import asdict
from importlib import import_module
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
import pytest
from fabricated import campaign, failed_record, fits, record
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text
from overlaps import assert_nothing_overlaps

from freerock import figures
from freerock.arrays import extremes
from freerock.config.figure_names import FIGURES
from freerock.figures import (
    contact_force,
    decay,
    foundation_effect,
    misfit_map,
    models,
    predictions,
    quality,
    restitution,
    set_up,
    style,
)
from freerock.figures.looks import MODEL_STYLES
from freerock.jobs.make_misfit_maps import make_misfit_maps
from freerock.models.block import Block
from freerock.models.contact import Foundation
from freerock.models.housner import housner_swings
from freerock.populations.predict import PREDICTIONS
from freerock.products.groups import runs_of
from freerock.products.netcdf import open_record, write_failure
from freerock.rotation.sensor import Laser
from freerock.rotation.view import View, sensor_attributes
from freerock.runs.verdict import Reason
from freerock.tables.number_text import quantity
from freerock.tables.tidy_tables import choice_table, epsilon_table, restitution_table, runs_table
from freerock_bench.figures.stability import ratio_axis_of

BLOCKS = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
LABELS = {"b1": "Slender block", "marble": "Marble"}


@pytest.fixture(scope="module")
def datasets():
    return campaign()


def texts(figure):
    return [text.get_text() for text in figure.findobj(Text)]


def test_foundation_effect_follows_the_papers_line_styles(datasets):
    figure, data = foundation_effect.draw(datasets[0], "simulated", LABELS)
    assert [ax.get_title(loc="left") for ax in figure.axes] == [
        "(a) Slender block",
        "(b) b2",
    ]
    told = "Drawn: run 1 of b1_marble, b1_mat, b2_marble and b2_mat."
    assert foundation_effect.caption(data).replace("\N{NO-BREAK SPACE}", " ") == told
    marble, mat = [line for line in figure.axes[1].lines if len(line.get_xdata()) > 2]
    assert (to_rgb(marble.get_color()), marble.get_linestyle()) == (to_rgb("black"), "-")
    assert to_rgb(mat.get_color())[2] > 0.7
    assert mat.get_linestyle() == "--"
    assert data.groupby(["block", "foundation"])["test"].unique().str.len().eq(1).all()


def test_labels_are_drawn_as_they_are_written(datasets):
    records, fitted = datasets
    labels = {"b1": "5 $ and $x_{$", "b2": r"\\frac{$", "marble": "_Marble", "mat": "$10^3$ " * 12}
    for figure, _ in (
        foundation_effect.draw(records, "simulated", labels),
        drawn_restitution(records, fitted, labels),
        *((page, None) for page in quality.failed(failed_record(), labels, "a $x_{$ reason")[0]),
    ):
        figure.draw_without_rendering()
    figure, _ = foundation_effect.draw(records, "simulated", labels)
    figure.draw_without_rendering()
    assert [text.get_text().strip() for text in figure.axes[0].get_legend().get_texts()] == [
        "_Marble",
        r"\$10^3\$ " * 11 + r"\$10^3\$",
    ]


@given(st.text("$\\_{} a", max_size=60))
def test_no_label_is_a_formula(text):
    for drawn in (style.as_text(text), style.wrapped(style.as_text(text) * 3, 0.3)):
        assert not Text(0, 0, "")._preprocess_math(drawn)[1], drawn
        assert not drawn.startswith("_")


def test_foundation_effect_draws_its_data_in_degrees_since_release(datasets):
    figure, data = foundation_effect.draw(datasets[0], "simulated")
    own = data[(data["block"] == "b2") & (data["foundation"] == "mat")]
    assert own["theta_deg"].iloc[0] == pytest.approx(-19.9, abs=0.05)
    assert own["time_s"].iloc[[0, -1]].tolist() == pytest.approx([0.0, 4.0])
    np.testing.assert_array_equal(figure.axes[1].lines[2].get_ydata(), own["theta_deg"])


def test_foundation_effect_leaves_out_failed_and_excluded_runs():
    tree = record(n_runs=3)
    tree["run_1"].attrs["verdict"] = "fail"
    _, data = foundation_effect.draw([failed_record(), tree], "simulated")
    assert set(data["run"]) == {2}
    tree["run_2"].attrs["excluded"] = 1
    assert foundation_effect.draw([tree], "simulated")[1].empty


def test_the_limits_of_noise_lie_above_a_residual_that_hides_what_is_behind_it(datasets):
    figure, _ = models.draw(datasets[1][:1], runs_table(datasets[0]), "simulated", LABELS)
    lines = figure.axes[1].get_lines()
    edges = [line for line in lines if abs(np.asarray(line.get_ydata())[0]) == style.NOISE]
    assert len(edges) == 2 and len(lines) > 2
    assert min(each.zorder for each in edges) > max(each.zorder for each in lines if each not in edges)
    assert "yellow lines" in models.FIGURE["caption"]


def test_models_shows_all_runs_their_named_law_and_the_residuals(datasets):
    figure, data = models.draw(datasets[1][:2], runs_table(datasets[0]), "simulated", LABELS)
    assert len(figure.axes) == 4
    assert data["source"].unique().tolist() == ["measured", "hunt_crossley"]
    own = data[data["test"] == "b1_mat"]
    assert own["run"].nunique() == 2
    run = own[own["run"] == 2]
    measured, law = (run[run["source"] == source] for source in ("measured", "hunt_crossley"))
    difference = law["theta_deg"].values - measured["theta_deg"].values
    np.testing.assert_allclose(law["residual_deg"], difference, atol=1e-9)
    np.testing.assert_allclose(law["residual_over_sigma"], difference / 0.01, atol=1e-6)
    (legend,) = figure.legends
    names = ["simulated record", "Hunt–Crossley", "noise: 95 %"]
    assert [text.get_text() for text in legend.get_texts()] == names
    assert any(text.startswith("$ε_θ$ = ") for text in texts(figure))
    runs = runs_of(datasets[1][0].copy(deep=True))
    for run, epsilon in zip(runs.values(), (9.7e-6, 1.17e-5), strict=True):
        run.children["hunt_crossley"]["epsilon_theta"] = epsilon
    assert models._laws(runs) == ["$ε_θ$ = 0.0010 … 0.0012 %"]


def test_models_names_the_runs_drawn_and_a_law_that_is_rejected():
    tree = record("b1_mat", "b1", "mat")
    fitted = fits(tree)
    figure, data = models.draw([fitted], runs_table([tree]), "simulated", LABELS)
    assert figure.axes[0].get_title(loc="left") == "Slender block, mat"
    assert models.caption(data) == "Drawn: runs\N{NO-BREAK SPACE}1 and 2 of b1_mat."
    assert not any("rejected" in text for text in texts(figure))
    fitted["run_1/choice"].attrs["explained"] = 0
    figure, _ = models.draw([fitted], runs_table([tree]), "simulated", LABELS)
    assert any(text.endswith(" %, rejected") for text in texts(figure))


def test_restitution_has_no_line_of_a_failed_fit():
    tree = record()
    _, whole = drawn_restitution([tree], [fits(tree)])
    figure, data = drawn_restitution([tree], [fits(tree, failed=["hunt_crossley"])])
    assert set(whole["source"]) == {"experiment", "hunt_crossley"}
    assert "hunt_crossley" not in set(data["source"])
    assert figure.axes[0].get_title(loc="left") == "b1"


def test_models_without_fits_says_so(datasets):
    figure, data = models.draw([fits(failed_record())], runs_table([failed_record()]), "simulated")
    assert data.empty
    assert "no fitted run" in texts(figure)


def drawn_restitution(records, fitted, labels=None, origin="simulated"):
    tables = runs_table(records), restitution_table(records, fitted), epsilon_table(fitted)
    return restitution.draw(*tables, BLOCKS, origin, labels)


def test_restitution_has_a_panel_per_block_and_leaves_out_excluded_runs(datasets):
    figure, data = drawn_restitution(*datasets, LABELS)
    assert len(figure.axes) == 2
    assert figure.axes[1].lines[0].get_ydata()[0] == pytest.approx(0.7, abs=1e-6)
    shown = {tuple(row) for row in data[["test", "run"]].values}
    assert ("b1_marble", 3) not in shown
    assert ("b1_marble", 2) in shown
    assert len(data) < len(restitution_table(*datasets))
    (legend,) = figure.legends
    told = [text.get_text() for text in legend.get_texts()]
    of_foundations = [
        f"{name}, {what}"
        for name in ("Marble", "mat")
        for what in ("simulated record", "law of the first run")
    ]
    assert told == ["rigid block (Housner 1963)", *of_foundations]


def test_a_rigid_block_decays_as_its_swings_do():
    block = BLOCKS["b1"]
    found = housner_swings(block, block.restitution_housner, 0.7 * block.theta_cr, max_impacts=12)
    seen = pd.DataFrame({"swing": np.arange(12.0), "amplitude": 0.7})
    swing, amplitude = decay._rigid(block, seen)
    assert list(swing) == list(range(12))
    np.testing.assert_allclose(amplitude, found.peak[:12] / block.theta_cr, rtol=1e-9)


def test_contact_begins_in_equilibrium_and_lifts_the_other_corner(datasets):
    figure, data = contact_force.draw(
        datasets[1], runs_table(datasets[0]), BLOCKS, "geometric", "simulated", LABELS
    )
    assert set(data["model"]) == {"hunt_crossley"} and len(figure.axes) == 8
    first = data.groupby("test").first()
    np.testing.assert_allclose(first["force_over_weight"], 1.0, rtol=1e-6)
    deeper, lifted = (first[["left_mm", "right_mm"]].agg(end, axis=1) for end in ("max", "min"))
    assert (deeper > 0).all() and (lifted < 0).all()
    drawn = data[data["test"] == "b1_marble"]
    for line, side in zip(figure.axes[0].lines, ("left", "right"), strict=True):
        assert line.get_label() == f"{side} corner"
        np.testing.assert_array_equal(line.get_ydata(), drawn[f"{side}_mm"].clip(lower=0))
    weights = [line.get_ydata() for ax in figure.axes for line in ax.lines if line.get_label() == "weight"]
    assert weights == [[1, 1]] * 4
    failed = failed_record()
    assert contact_force.draw([fits(failed)], runs_table([failed]), BLOCKS, "geometric", "simulated")[1].empty


def test_contact_begins_where_the_block_lay_and_not_where_the_beam_sees_it(datasets):
    """A beam below the top shows another angle of a block whose corner has sunk."""
    tree, view = datasets[1][0].copy(), View(BLOCKS["b1"], Laser("horizontal", 0.2))
    of_block = {f"block_{name}": value for name, value in asdict(view.block).items() if value is not None}
    runs, leans = runs_table(datasets[0]), []
    for attrs in ({}, sensor_attributes(view) | of_block):
        tree.attrs |= attrs
        first = contact_force.draw([tree], runs, BLOCKS, "geometric", "simulated", LABELS)[1].iloc[0]
        leans.append(np.arcsin(1e-3 * (first["right_mm"] - first["left_mm"]) / BLOCKS["b1"].width_m))
    seen, lay = leans
    law = {name: float(value) for name, value in _selected(tree).items()}
    assert lay == pytest.approx(view.released(seen, view.block, Foundation.of(law)))
    assert abs(lay / seen - 1) > 1e-3


def _selected(tree):
    fit = runs_of(tree)[1]["hunt_crossley"].dataset
    return dict(zip(fit["parameter"].values, fit["value"].values, strict=True))


def test_the_set_up_is_drawn_to_scale():
    lasers = [{"name": "high", "beam": "horizontal", "position_m": 0.2, "face": "left"}]
    lasers += [{"name": "top", "beam": "vertical", "position_m": 0.01, "face": "left"}]
    lasers += [{"name": "angle", "beam": None, "position_m": None, "face": "left"}]
    set_ups = {"b1": {"foundations": ["marble", "mat"], "lasers": lasers}}
    figure, data = set_up.draw(BLOCKS, set_ups, "measured", LABELS)
    body = figure.axes[0].patches[0]
    assert (body.get_width(), body.get_height()) == (BLOCKS["b1"].width_m, BLOCKS["b1"].height_m)
    assert figure.axes[0].get_aspect() == 1
    assert {"200 mm", "10 mm", "α", "R"} <= {*texts(figure)}
    assert data["alpha_deg"].tolist() == pytest.approx([np.degrees(BLOCKS["b1"].theta_cr)] * 3)
    assert set_up.caption(data, LABELS) == "Slender block on Marble, mat."


def test_blocks_of_every_row_are_drawn_to_one_scale():
    shapes = {f"b{i}": Block(0.6 - 0.05 * i, 0.06, 1.0) for i in range(9)}
    set_ups = {name: {"foundations": ["table"], "lasers": []} for name in shapes}
    figure, _ = set_up.draw(shapes, set_ups, "measured")
    figure.draw_without_rendering()
    assert len(figure.axes) == 9  # three by three, no row with one block
    scales = [ax.get_window_extent().height / np.ptp(ax.get_ylim()) for ax in figure.axes]
    np.testing.assert_allclose(scales, scales[0], rtol=0.01)
    heights = [ax.get_window_extent().height for ax in figure.axes]
    assert heights[8] < 0.8 * heights[0]


def test_blocks_on_one_foundation_stand_side_by_side():
    scenes = [(f"b{i}", "table") for i in range(4)]
    with style.styled():
        matplotlib.rcParams["figure.figsize"] = 7.0, 1.0
        figure, panels = style.panels_per_scene(scenes, None, 2.0, (1.5, 1.0))
        style.outer_labels({scene: own[1] for scene, own in panels.items()}, "x", "y")
    assert list(panels) == scenes and figure.get_figheight() == pytest.approx(4.5)
    columns = [own[0].get_subplotspec().colspan.start for own in panels.values()]
    assert columns == [0, 1, 0, 1]
    assert [own[0].get_title(loc="left") for own in panels.values()][3] == "(d) b3, table"
    assert all(own[0].get_shared_x_axes().joined(*own) for own in panels.values())


def test_a_place_without_a_record_is_empty_and_the_panel_above_it_has_numbers():
    scenes = [("a", "x"), ("a", "y"), ("b", "x")]
    with style.styled():
        figure, panels = style.panel_per_scene(scenes, None, 2.0, sharex=True)
        style.outer_labels(panels, "frequency", "density")
    assert [ax.axison for ax in figure.axes] == [True, True, True, False]
    assert [ax.get_xlabel() for ax in panels.values()] == ["", "frequency", "frequency"]
    assert [ax.get_title(loc="left")[:3] for ax in panels.values()] == ["(a)", "(b)", "(c)"]
    figure.draw_without_rendering()
    shown = [ax.xaxis.get_major_ticks()[0].label1.get_visible() for ax in panels.values()]
    assert shown == [False, True, True]


def test_numbers_of_an_axis_differ():
    ax = Figure().subplots()
    style.number_ticks(ax.xaxis, 1.987e6, 2.013e6, 2, 0.25)
    texts_of_ticks = [tick.get_text() for tick in ax.get_xticklabels()]
    assert len(set(texts_of_ticks)) == len(texts_of_ticks) > 1


def test_restitution_without_any_impact():
    broken = failed_record()
    figure, data = drawn_restitution([broken], [fits(broken)])
    assert data.empty
    assert len(figure.axes) == 1


def test_quality_has_a_page_per_run_with_verdict_and_reasons(datasets):
    pages, data = quality.draw(datasets[0][0], datasets[1][0], LABELS)
    assert len(pages) == 3
    assert "ok" in texts(pages[0])
    assert "warn, excluded" in texts(pages[2])
    assert any("slid" in text for text in texts(pages[2]))
    shades = [
        each.get_color()
        for page in pages
        for each in page.texts
        if each.get_text().startswith(("ok", "warn"))
    ]
    assert [quality.VERDICT_COLOURS["ok"], quality.VERDICT_COLOURS["excluded"]] == [shades[0], shades[2]]
    assert any("; 4 zero crossings, 4 with r" in text for text in texts(pages[0]))
    assert "not fitted" in texts(pages[2])
    assert "not fitted" not in texts(pages[0])
    assert {"voltage", "theta", "error_level"} <= set(data[data["run"].isna()]["series"])
    assert (data["series"] == "impact").sum() == 12
    instants = {text.get_text().strip(): text.get_position()[0] for text in pages[0].axes[2].texts}
    assert instants == {"release": 2, "rest": 6}
    assert data[data["series"] == "error_level"]["value"].tolist() == pytest.approx([10.2] * 5)


def test_quality_begins_with_what_was_found_and_what_is_doubtful(datasets):
    pages, _ = quality.draw(datasets[0][0], datasets[1][0], LABELS)
    words = texts(pages[0])
    found = next(
        text
        for text in words
        if text.startswith("Found: Hunt–Crossley explains the run: k\N{NO-BREAK SPACE}=")
    )
    doubtful = next(text for text in words if text == "No check found a doubt")
    assert any("$ε_θ$" in text for text in words)
    assert words.index(found) < words.index(doubtful)
    left_out = texts(pages[2])
    assert "Found: not fitted" in left_out
    assert any(text.startswith("Doubtful: excluded: the block slid") for text in left_out)
    labels = [ax.get_ylabel() for ax in pages[0].axes]
    assert labels == ["θ / °", "residual / σ", "θ / °", "laser / V"]
    nearest, _ = quality.draw(datasets[0][0], fits(datasets[0][0], models=("housner", "winkler")))
    assert any("comes nearest, none explains the run" in text for text in texts(nearest[0]))


def test_quality_prints_total_uncertainties_and_says_so_where_there_are_only_the_noise_s(datasets):
    record, fitted = datasets[0][0], datasets[1][0].copy(deep=True)
    fit = runs_of(fitted)[1].children["hunt_crossley"]

    def words():
        return " ".join(" ".join(texts(quality.draw(record, fitted)[0][0])).split())

    k, noise = (float(fit[name][0]) for name in ("value", "stderr"))
    assert f"k = {quantity(k, noise)} " in words() and "± noise alone" in words()
    fit["u_total"] = 3 * fit["stderr"]
    assert f"k = {quantity(k, 3 * noise)} " in words() and "± total uncertainty" in words()


def test_quality_shows_the_noise_on_top_of_the_residual(datasets):
    pages, _ = quality.draw(datasets[0][0], datasets[1][0])
    residual = pages[0].axes[1]
    assert residual.get_ylabel() == "residual / σ"
    edges = [line.get_ydata()[0] for line in residual.lines if line.get_zorder() > 2]
    assert edges == pytest.approx([-1.96, 1.96])
    drawn = [line for line in residual.lines if line.get_zorder() == 2]
    assert len(drawn) == 3
    marks = {label.get_text() for label in residual.get_yticklabels()}
    assert max(residual.get_ylim()) > 100 and {"3", "−3", "100"} <= marks and "10" not in marks


def test_quality_shows_no_noise_where_nothing_was_fitted(datasets):
    residual = quality.draw(datasets[0][0], datasets[1][0])[0][2].axes[1]
    (told,) = residual.texts
    assert told.get_text() == "not fitted" and not len(residual.get_yticks())
    assert not residual.lines and not residual.patches
    assert residual.get_legend() is None


def test_quality_of_a_failed_record_tells_the_reason():
    broken = failed_record()
    (page,), data = quality.draw(broken, fits(broken))
    assert "fail" in texts(page)
    assert any(text.startswith("Failed: b1_broken.tdms: the file is truncated") for text in texts(page))
    assert data.empty and not page.axes


def test_quality_of_a_record_without_runs_shows_its_signal(datasets, tmp_path):
    """As of one in which nothing moves: θ(t) is known, and no run."""
    whole = datasets[0][0]
    attrs = {key: whole.attrs[key] for key in ("campaign", "test", "block", "foundation", "origin")}
    still = Reason("fail", "not_processed", "nothing moves")
    write_failure(tmp_path / "still.nc", still, attrs, whole.to_dataset().drop_attrs())
    broken = open_record(tmp_path / "still.nc")
    (page,), data = quality.draw(broken, fits(broken))
    assert "Failed: nothing moves" in texts(page)
    assert [ax.get_ylabel() for ax in page.axes] == ["θ / °", "laser / V"]
    assert all(len(ax.lines[0].get_xdata()) > 100 for ax in page.axes)
    assert {"voltage", "theta", "error_level"} == set(data["series"]) and data["run"].isna().all()
    (named,), none = quality.failed(broken, None, "unforeseen")
    assert none.empty and not named.axes


@pytest.mark.parametrize(("origin", "said"), [("simulated", True), ("measured", False)])
def test_footer_says_that_a_record_is_simulated(origin, said):
    tree = record(origin=origin, n_runs=1)
    fitted = fits(tree)
    figures = [
        foundation_effect.draw([tree], origin)[0],
        models.draw([fitted], runs_table([tree]), origin)[0],
    ]
    figures.append(drawn_restitution([tree], [fitted], origin=origin)[0])
    for figure in [*figures, *quality.draw(tree, fitted)[0]]:
        assert (style.FOOTER in texts(figure)) is said


def test_every_axis_is_labelled_with_its_unit_and_nothing_overlaps(datasets):
    records, fitted = datasets
    figures = [foundation_effect.draw(records, "simulated", LABELS)[0]]
    figures += [
        contact_force.draw(fitted[:2], runs_table(records), BLOCKS, "geometric", "simulated", LABELS)[0]
    ]
    figures += [models.draw(fitted[:2], runs_table(records), "simulated", LABELS)[0]]
    figures += [drawn_restitution(records, fitted, LABELS)[0], quality.draw(records[0], fitted[0])[0][2]]
    for figure in figures:
        figure.draw_without_rendering()
        labels = [ax.get_ylabel() for ax in figure.axes if ax.get_subplotspec().is_first_col()]
        labels += [ax.get_xlabel() for ax in figure.axes if ax.get_subplotspec().is_last_row()]
        assert all(" / " in text or text.startswith(("restitution", "amplitude")) for text in labels)
        boxes = [ax.get_tightbbox() for ax in figure.axes]
        boxes += [artist.get_window_extent() for artist in (*figure.texts, *figure.legends)]
        for i, box in enumerate(boxes):
            assert not any(box.overlaps(other) for other in boxes[i + 1 :])


def test_same_figure_same_bytes(tmp_path, datasets):
    for name in ("one", "two"):
        style.save(*drawn_restitution(*datasets), tmp_path / name)
    for suffix in (".pdf", ".png", ".csv"):
        assert (tmp_path / f"one{suffix}").read_bytes() == (tmp_path / f"two{suffix}").read_bytes()
    assert len(list(tmp_path.iterdir())) == 6
    pdf = (tmp_path / "one.pdf").read_bytes()
    assert b"CreationDate" not in pdf
    assert b"/FontFile2" in pdf
    assert b"/Type3" not in pdf
    assert b"Software" not in (tmp_path / "one.png").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("target", "width_in"), [("single_column", 3.5), ("double_column", 7), ("slide", 10)]
)
def test_each_target_has_its_width_and_nothing_overlaps(tmp_path, datasets, target, width_in):
    tables = runs_table(datasets[0]), restitution_table(*datasets), epsilon_table(datasets[1])
    drawings = {
        "foundation": lambda: foundation_effect.draw(datasets[0], "simulated", LABELS, target=target),
        "models": lambda: models.draw(
            datasets[1][:2], runs_table(datasets[0]), "simulated", LABELS, target=target
        ),
        "restitution": lambda: restitution.draw(*tables, BLOCKS, "simulated", LABELS, target=target),
        "predictions": lambda: predictions.draw(*predicted(datasets), "simulated", LABELS, target=target),
    }
    for name, draw in drawings.items():
        figure, _ = draw()
        assert figure.get_figwidth() == width_in
        assert_nothing_overlaps(figure, name)
        copies = "ab" if target == "double_column" else "a"
        for copy in copies:
            style.save(*draw(), tmp_path / f"{name}_{copy}", target=target)
        for suffix in (".pdf", ".png"):
            contents = {(tmp_path / f"{name}_{copy}{suffix}").read_bytes() for copy in copies}
            assert len(contents) == 1, (name, suffix)
        assert b"/FontFile2" in (tmp_path / f"{name}_a.pdf").read_bytes()


def predicted(datasets):
    epsilon = epsilon_table(datasets[1])
    rows = epsilon.assign(n_runs=2)
    others = [
        rows.assign(basis=basis, epsilon_theta=3 * rows["epsilon_theta"]) for basis in ("other runs", "b2")
    ]
    return pd.concat(others)[PREDICTIONS], epsilon


def test_predictions_stand_beside_the_fit_of_the_run_itself(datasets):
    frame, epsilon = predicted(datasets)
    figure, data = predictions.draw(frame, epsilon, "simulated", LABELS)
    (ax,) = figure.axes
    assert ax.get_title(loc="left") == "Hunt–Crossley"
    assert set(data["model"]) == {"hunt_crossley"}
    assert len(data) == 1.5 * (frame["model"] == "hunt_crossley").sum()
    assert set(data["basis"]) == {"fitted to the run itself", "other runs", "b2"}
    own, *others = ax.lines
    fits_of_runs = data[data["basis"] == predictions.OWN]["epsilon_theta"]
    np.testing.assert_allclose(own.get_xdata(), 100 * fits_of_runs)
    level = np.array([0, 0, 1, 1, 2, 2, 3])
    np.testing.assert_allclose(own.get_ydata(), level - 0.22)
    for line, shift in zip(others, (0, 0.22), strict=True):
        np.testing.assert_allclose(line.get_xdata(), 300 * fits_of_runs)
        np.testing.assert_allclose(line.get_ydata(), level + shift)
    assert style.FOOTER in texts(figure)


def test_predictions_are_of_the_law_named_for_each_scene(datasets):
    frame, epsilon = predicted(datasets)
    named = np.where(epsilon["foundation"] == "marble", "housner", "hunt_crossley")
    epsilon["selected"] = epsilon["model"] == named
    figure, data = predictions.draw(frame, epsilon, "simulated", LABELS)
    drawn = data.groupby("model")["foundation"].unique().map(list).to_dict()
    assert drawn == {"housner": ["marble"], "hunt_crossley": ["mat"]} and len(figure.axes) == 2


def test_a_single_run_of_a_single_block_predicts_nothing_and_its_own_fits_are_shown():
    epsilon = epsilon_table([fits(record(n_runs=1), failed=["winkler"])]).assign(selected=False)
    figure, data = predictions.draw(pd.DataFrame(columns=PREDICTIONS), epsilon, "simulated")
    housner, winkler, hunt_crossley = figure.axes
    assert [len(ax.lines[0].get_xdata()) for ax in figure.axes] == [1, 0, 1]
    assert [text.get_text() for text in winkler.texts] == ["failed fit"]
    assert not housner.texts and not hunt_crossley.texts
    assert set(data["basis"]) == {"fitted to the run itself"}
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["fitted to the run itself"]


def test_predictions_have_tick_labels_in_each_panel(datasets):
    """Of five models two stand in a second row, and the third of the first row has no panel below."""
    frame, epsilon = predicted(datasets)
    more = {"winkler": "winkler_pivoting", "hunt_crossley": "hunt_crossley_pivoting"}
    epsilon = epsilon.assign(selected=True)  # every law is named
    rivals = [table[table["model"].isin(more)].replace({"model": more}) for table in (frame, epsilon)]
    figure, _ = predictions.draw(
        pd.concat([frame, rivals[0]]), pd.concat([epsilon, rivals[1]]), "simulated", LABELS
    )
    figure.draw_without_rendering()
    drawn = [ax for ax in figure.axes if ax.axison]
    assert len(drawn) == 5
    for ax in drawn:
        assert any(
            tick.label1.get_visible() and tick.label1.get_text() for tick in ax.xaxis.get_major_ticks()
        )
    assert [bool(ax.get_xlabel()) for ax in drawn] == [False, False, True, True, True]


@pytest.mark.parametrize("failed", [["housner", "winkler", "hunt_crossley"], None])
def test_no_prediction_at_all_says_why(failed):
    epsilon = epsilon_table([fits(failed_record()) if failed is None else fits(record(), failed)])
    figure, data = predictions.draw(pd.DataFrame(columns=PREDICTIONS), epsilon, "simulated")
    assert data.empty
    assert "nothing to predict: no run has a fit that may be used" in texts(figure)


def test_panels_are_lettered_beyond_z():
    assert [style.letter(i) for i in (0, 25, 26, 51, 52, 702)] == ["a", "z", "aa", "az", "ba", "aaa"]


def test_every_candidate_is_told_from_the_others_in_grey():
    grey = [np.dot(to_rgb(each["color"]), (0.299, 0.587, 0.114)) for each in MODEL_STYLES.values()]
    looks = list(zip(grey, map(str, (each["linestyle"] for each in MODEL_STYLES.values())), strict=True))
    for i, (shade, line) in enumerate(looks):
        assert all(abs(shade - other) > 0.1 or line != dashes for other, dashes in looks[i + 1 :])


def test_pages_of_different_height_are_stacked(tmp_path):
    pages = [Figure(figsize=(2, height)) for height in (1, 2)]
    style.save(pages, pd.DataFrame({"x": [1.0]}), tmp_path / "pages")
    assert b"/Count 2" in (tmp_path / "pages.pdf").read_bytes()
    width, height = np.frombuffer((tmp_path / "pages.png").read_bytes()[16:24], ">u4")
    assert height == pytest.approx(1.5 * width, abs=2)


def test_no_state_is_shared_through_pyplot():
    modules = Path(style.__file__).parent.glob("*.py")
    assert not [module.name for module in modules if "pyplot" in module.read_text(encoding="utf-8")]


@given(st.integers(0, 5000), st.integers(1, 2000))
def test_thinning_keeps_the_ends(n, n_drawn):
    kept = style.thin(n, n_drawn)
    assert len(kept) <= max(2 * n_drawn + 1, 2)
    if n:
        assert (kept[0], kept[-1]) == (0, n - 1)


@given(st.lists(st.floats(-1e3, 1e3) | st.just(np.nan), max_size=300), st.integers(1, 50))
def test_extremes_keep_the_highest_and_lowest_sample(values, n_bins):
    kept = extremes(values, n_bins)
    assert len(kept) <= 2 * n_bins
    assert np.all(np.diff(kept) > 0)
    finite = np.array(values)[np.isfinite(values)] if values else []
    if len(finite):
        shown = np.array(values)[kept]
        assert (np.nanmin(shown), np.nanmax(shown)) == (min(finite), max(finite))


def test_misfit_map_marks_every_fit_and_leaves_out_failed_ones(datasets, tmp_path, monkeypatch):
    tree, failed = datasets[1][0], fits(record(), failed=["hunt_crossley", "winkler"])
    files = {"good.nc": tree, "failed.nc": failed}
    monkeypatch.setattr("freerock.jobs.make_misfit_maps.open_fits", lambda path, only=None: files[path])
    settings = {"blocks": {name: asdict(block) for name, block in BLOCKS.items()}, "debonding": "geometric"}
    make_misfit_maps(settings, list(files), ["one", "other"], tmp_path / "misfit_map.nc")
    maps, choice = misfit_map.read(tmp_path / "misfit_map.nc"), choice_table([tree])
    figure, data = misfit_map.draw(maps, choice, "simulated", LABELS)
    identified = data[data["quantity"] == "identified"]
    assert identified["run"].tolist() == [1, 2]
    assert identified["correlation"].abs().max() <= 1
    assert set(data["test"]) == {tree.attrs["test"]}
    grid = data[data["quantity"] == "grid"]
    assert grid["k"].min() == pytest.approx(6.88e6 * np.exp(-0.3))
    assert figure.axes[0].get_xlabel() == "k / (N m⁻²)" and figure.axes[0].get_ylabel() == "λ / (N s m⁻³)"
    assert "simulated record – not the laboratory's data" in texts(figure)
    assert figure.axes[0].get_title(loc="left") == "Slender block, Marble: Hunt–Crossley"
    assert misfit_map.caption(data) == "Drawn: run\N{NO-BREAK SPACE}1 of b1_marble."
    coarse, _ = misfit_map.draw([maps[0].isel(k=[0, -1])], choice, "simulated", LABELS)
    for each in (figure, coarse):
        ticks = [text.get_text() for text in each.axes[0].get_xticklabels()]
        assert ticks == ["6.0·10⁶", "8.0·10⁶"]
    others, drawn = figure.axes[0].lines
    assert drawn.get_xdata() == identified["k"].iloc[0] and others.get_xdata() == identified["k"].iloc[1]
    assert (drawn.get_markerfacecolor(), others.get_markerfacecolor()) == ("black", "white")
    named = [text.get_text() for text in figure.legends[0].get_texts()]
    assert named[1:] == ["identified on that run: the minimum", "on the other runs"]
    assert "law rejected" not in texts(figure)
    choice.loc[(choice["model"] == "hunt_crossley") & (choice["run"] == 1), "status"] = "rejected"
    assert "law rejected" in texts(misfit_map.draw(maps, choice, "simulated", LABELS)[0])


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_of_a_campaign_is_a_module_that_draws_and_captions(name):
    module = import_module(f"freerock.figures.{name}")
    draw = inspect.signature(module.draw)
    assert {"origin", "labels"} < set(draw.parameters)
    assert [*inspect.signature(module.caption).parameters] == ["data", "labels"]
    assert name in figures.__all__


def test_axes_of_parameters_have_the_units_of_the_laws():
    assert [style.axis_of(name) for name in ("k", "c", "lambda", "t0")] == [
        "k / (N m⁻²)",
        "c / (N s m⁻²)",
        "λ / (N s m⁻³)",
        "t₀ / s",
    ]
    assert [ratio_axis_of(name) for name in ("c", "lambda")] == ["c/k / s", "λ/k / (s m⁻¹)"]
