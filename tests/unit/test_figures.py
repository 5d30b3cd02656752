import inspect
import subprocess
import sys
from importlib import import_module

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
from PIL import Image

from freerock.figures import (
    comparison,
    foundation_effect,
    predictions,
    quality,
    restitution,
    set_up,
    style,
)
from freerock.figures.listed import FIGURES, entry_of
from freerock.figures.looks import extremes
from freerock.models.block import Block
from freerock.models.laws import MODEL_LABELS, PAPER_MODELS
from freerock.products.netcdf import open_record, write_failure
from freerock.runs.verdict import Reason
from freerock.tables.number_text import quantity
from freerock.tables.tidy_tables import epsilon_table, restitution_table, runs_table

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
    assert figure.axes[1].texts[0].get_text() == "α = 19.9° and 19.9°\nrun 1 and run 1"
    marble, mat = [line for line in figure.axes[1].lines if len(line.get_xdata()) > 2]
    assert (to_rgb(marble.get_color()), marble.get_linestyle()) == (to_rgb("black"), "-")
    assert to_rgb(mat.get_color())[2] > 0.7
    assert mat.get_linestyle() == "--"
    assert data.groupby(["block", "foundation"])["test"].unique().str.len().eq(1).all()


def test_foundation_effect_draws_the_runs_released_most_alike_to_one_side():
    records = [record("b1_marble"), record("b1_mat", "b1", "mat", theta0_deg=-10.4)]  # runs of 10.1 and 10.2°
    figure, data = foundation_effect.draw(records, "simulated")
    assert set(data["run"]) == {2}
    assert figure.axes[0].texts[0].get_text() == "α = 10.2° and 10.2°\nrun 2 and run 2"
    assert data.groupby("test")["theta_deg"].first().tolist() == pytest.approx([10.2, 10.2], abs=0.05)
    (alone,) = foundation_effect.draw(records[:1], "simulated")[0].axes
    assert alone.texts[0].get_text() == "α = 10.1°\nrun 1"


def test_foundation_effect_says_where_runs_last_longest_and_whether_they_do_in_the_paper():
    scenes = [("b1", "marble", 9.0), ("b1", "aerstop", 5.0), ("b2", "marble", 2.4), ("b2", "aerstop", 1.3)]
    data = pd.DataFrame(scenes, columns=["block", "foundation", "time_s"])
    labels = {"b1": "Block 1, h/b = 4", "b2": "Block 2, h/b = 2", "marble": "Marble"}
    data = data.assign(test=data["block"] + "_" + data["foundation"], run=[1, 2, 1, 1])
    told = foundation_effect.caption(data, labels)
    assert told.startswith("Every block rocks longer on Marble.")
    assert " the same of Block 1, the reverse of Block 2. " in told
    assert told.endswith(" of b1_marble, b2_marble and b2_aerstop; run\N{NO-BREAK SPACE}2 of b1_aerstop.")
    data.loc[3, "time_s"] = 3.0
    told = foundation_effect.caption(data, labels)
    assert told.startswith("Block 1 rocks longer on Marble. Block 2 rocks longer on aerstop.")
    assert " the same of Block 1 and Block 2. " in told
    told = foundation_effect.caption(data)
    assert told.startswith("b1 rocks longer on marble. b2 rocks longer on aerstop. ")
    other = data.replace({"foundation": {"aerstop": "mat"}})
    assert "paper" not in foundation_effect.caption(other, labels)  # it has another foundation
    alone = foundation_effect.caption(data[data["foundation"] == "marble"], labels)
    assert "aerstop" not in alone


def test_foundation_effect_draws_its_data_in_degrees_since_release(datasets):
    figure, data = foundation_effect.draw(datasets[0], "simulated")
    own = data[(data["block"] == "b2") & (data["foundation"] == "mat")]
    assert own["theta_deg"].iloc[0] == pytest.approx(19.9, abs=0.05)  # released to the other side
    assert own["time_s"].iloc[[0, -1]].tolist() == pytest.approx([0.0, 4.0])
    np.testing.assert_array_equal(figure.axes[1].lines[2].get_ydata(), own["theta_deg"])


def test_comparison_has_the_three_laws_below_each_other_with_epsilon_in_the_legend(datasets):
    figure, data = comparison.draw(datasets[1], runs_table(datasets[0]), "simulated", LABELS)
    assert len(figure.axes) == 12  # three panels of each of four scenes
    assert set(data["source"]) == {"measured", "housner", "winkler", "hunt_crossley", "selected"}
    own = data[(data["test"] == "b1_mat")]
    measured, law, free = (own[own["source"] == each] for each in ("measured", "winkler", "selected"))
    off = law["theta_deg"].to_numpy() - measured["theta_deg"].to_numpy()
    release = abs(measured["theta_deg"].iloc[0])
    np.testing.assert_allclose(law["residual_over_theta0"], off / release, atol=1e-12)
    residual = datasets[1][1]["run_1/hunt_crossley"]["residual"].values
    assert free["residual_over_sigma"].iloc[0] == pytest.approx(np.degrees(residual[0]) / 0.01)
    assert legend(figure)[:4] == ["simulated record", "Housner", "Winkler", "Hunt–Crossley"]
    assert legend(figure)[4:] == ["Δθ/σ: Hunt–Crossley", "95 % of the noise"]
    assert all(test in comparison.caption(data) for test in data["test"].unique())
    epsilon = datasets[1][0]["run_1/winkler"]["epsilon_theta"].item()
    told = figure.axes[0].texts[0].get_text()
    assert told.split(", ")[1] == quantity(100 * epsilon, digits=2)
    assert told.startswith(f"run {data['run'].iloc[0]}; ")
    scales = {ax.get_ylim() for ax in figure.axes if ax.get_ylabel() == "Δθ / α"}
    assert len(scales) == 1


def test_comparison_says_of_a_failed_fit_that_it_failed():
    tree = record("b1_mat", "b1", "mat")
    figure, data = comparison.draw([fits(tree, failed=["housner"])], runs_table([tree]), "simulated")
    assert "housner" not in set(data["source"]) and any("; $ε_θ$: failed, " in each for each in texts(figure))
    lost = failed_record()
    figure, data = comparison.draw([fits(lost)], runs_table([lost]), "simulated")
    assert data.empty and "no fitted run" in texts(figure)


def test_comparison_names_the_law_that_is_selected_wherever_one_is():
    trees = [record("b1_mat", "b1", "mat"), record("b1_marble", "b1", "marble")]
    fitted = [fits(trees[0]), fits(trees[1], failed=PAPER_MODELS)]
    figure, _ = comparison.draw(fitted, runs_table(trees), "simulated")
    assert "Δθ/σ: Hunt–Crossley" in legend(figure)


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def drawn_restitution(records, fitted, labels=None, origin="simulated"):
    tables = runs_table(records), restitution_table(records, fitted), epsilon_table(fitted)
    return restitution.draw(*tables, BLOCKS, origin, labels)


def test_restitution_has_a_panel_per_scene_and_leaves_out_excluded_runs(datasets):
    figure, data = drawn_restitution(*datasets, LABELS)
    assert len(figure.axes) == 4
    rigid = next(line for line in figure.axes[2].lines if line.get_linestyle() == ":")
    assert rigid.get_ydata()[0] == pytest.approx(0.7, abs=1e-6)
    shown = {tuple(row) for row in data[["test", "run"]].values}
    assert ("b1_marble", 3) not in shown and ("b1_marble", 2) in shown
    modelled = data[data["source"] != "experiment"]
    assert set(modelled["run"]) == {1} and set(modelled["source"]) == {"housner", "winkler", "hunt_crossley"}
    assert {*legend(figure)} == {
        "rigid block (Housner 1963)",
        "95 % of impacts, selected law and σ$_r$",
        "simulated record: run 1",
        "run 2",
        *("Housner", "Winkler", "Hunt–Crossley"),
    }


def test_a_legend_names_each_run_that_is_drawn_with_its_record():
    records = [record("a", n_runs=1), record("b", n_runs=2), record("b2_mat", "b2", "mat", n_runs=1)]
    figure, _ = drawn_restitution(records, [fits(each) for each in records], origin="measured")
    assert legend(figure)[:3] == ["measured: record 1, run 1", "b, run 1", "b, run 2"]
    drawn = {bars.get_label(): bars.lines[0].get_marker() for ax in figure.axes for bars in ax.containers}
    named = [handle.get_marker() for handle in figure.legends[0].legend_handles[:3]]
    assert named == list(drawn.values()) == ["o", "s", "^"]
    alone, _ = drawn_restitution(records[:2], [fits(each) for each in records[:2]])
    assert legend(alone)[0] == "simulated record: a, run 1"


@pytest.mark.slow
def test_of_many_runs_a_legend_names_the_first_and_counts_the_others():
    records = [record(f"t{i}", n_runs=2) for i in range(7)]
    figure, _ = drawn_restitution(records, [fits(each) for each in records])
    assert legend(figure)[11:13] == ["t5, run 2", "2 more runs"]


def test_restitution_has_a_band_only_where_impacts_scatter_about_a_line_that_is_drawn():
    tree, band = record("b1_mat", "b1", "mat"), "95 % of impacts, selected law and σ$_r$"
    figure, data = drawn_restitution([tree], [fits(tree)])
    assert band in legend(figure) and "Band" in restitution.caption(data)
    assert set(data["selected"]) == {"hunt_crossley"} and set(data["sigma_r"]) == {0.006}
    pivoting = fits(tree, models=(*PAPER_MODELS, "hunt_crossley_pivoting"))
    figure, data = drawn_restitution([tree], [pivoting])
    assert band not in legend(figure) and "Band" not in restitution.caption(data)
    assert MODEL_LABELS["hunt_crossley_pivoting"] in restitution.caption(data)
    rigid = fits(tree)
    tables = runs_table([tree]), restitution_table([tree], [rigid]), epsilon_table([rigid])
    figure, data = restitution.draw(*tables[:2], tables[2].assign(sigma_r=0.0), BLOCKS, "simulated")
    assert band not in legend(figure) and "Band" not in restitution.caption(data)


def test_words_about_a_law_without_a_line_lie_below_all_that_is_drawn():
    tree = record("b1_mat", "b1", "mat")
    tables = runs_table([tree]), restitution_table([tree], [fits(tree)]), epsilon_table([fits(tree)])
    absent = tables[1][tables[1]["source"] != "housner"]
    (ax,) = (figure := restitution.draw(tables[0], absent, tables[2], BLOCKS, "simulated")[0]).axes
    figure.draw_without_rendering()
    assert "Housner" not in legend(figure)
    lowest = min(np.nanmin(line.get_ydata()) for line in ax.lines)
    assert ax.texts[0].get_window_extent().y1 < ax.transData.transform((0, lowest))[1]


def test_the_set_up_is_drawn_to_scale():
    lasers = [{"name": "high", "beam": "horizontal", "position_m": 0.2, "face": "left"}]
    lasers += [{"name": "top", "beam": "vertical", "position_m": 0.01, "face": "left"}]
    lasers += [{"name": "angle", "beam": None, "position_m": None, "face": "left"}]
    set_ups = {"b1": {"foundations": ["marble", "mat"], "lasers": lasers}}
    figure, data = set_up.draw(BLOCKS, set_ups, "measured", LABELS)
    body = figure.axes[0].patches[0]
    assert (body.get_width(), body.get_height()) == (BLOCKS["b1"].width_m, BLOCKS["b1"].height_m)
    assert figure.axes[0].get_aspect() == 1
    radius = next(text for text in figure.axes[0].texts if text.get_text() == "R")
    assert radius.get_position()[1] < 0.5 * BLOCKS["b1"].h  # well below the cross
    assert {"200 mm", "10 mm", "$θ_{cr}$", "R"} <= {*texts(figure)}
    assert data["theta_cr_deg"].tolist() == pytest.approx([np.degrees(BLOCKS["b1"].theta_cr)] * 3)
    assert "Slender block" in {ax.get_title(loc="left") for ax in figure.axes}
    assert any(text.endswith("on Marble, mat") for text in texts(figure))
    assert "Arrows" in set_up.caption(data) and "Arrows" not in set_up.caption(data[data["beam"] == ""])


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


def test_a_page_sets_the_theta_of_epsilon_as_an_index(datasets):
    page = quality.draw(datasets[0][0], datasets[1][0], LABELS)[0][0]
    (text,) = (each for each in texts(page) if "ε_θ" in each)
    assert "$ε_θ$\N{NO-BREAK SPACE}of\N{NO-BREAK SPACE}this\N{NO-BREAK SPACE}fit" in text


def test_a_page_draws_dollars_as_they_are():
    ((page,), _) = quality.failed(failed_record(), LABELS, "raw/$a_$b.tdms: ε_θ")
    page.draw_without_rendering()
    assert any(r"raw/\$a_\$b.tdms: $ε_θ$" in text for text in texts(page))


def test_a_page_draws_the_selected_law_last_in_black_with_one_rival_under_a_legend_that_is_clear_of_ticks():
    tree = record(n_runs=1)
    rivals = "winkler_pivoting", "hunt_crossley_width", "hunt_crossley_pivoting_width"
    (page,), data = quality.draw(tree, fits(tree, models=(*PAPER_MODELS, *rivals)))
    motion, residual = page.axes[:2]
    laws = [line for line in residual.lines if len(line.get_xdata()) > 2]
    names = ["Housner", "Winkler", "Hunt–Crossley", "Hunt–Crossley, width free"]
    assert [line.get_label() for line in laws] == [*names, "Hunt–Crossley, pivoting, width free (selected)"]
    assert [to_rgb(line.get_color()) == to_rgb("black") for line in laws] == 4 * [False] + [True]
    assert "residual_winkler_pivoting" not in set(data["series"])
    page.draw_without_rendering()
    assert not residual.get_legend().get_window_extent().overlaps(motion.get_tightbbox())
    assert page.axes[1].yaxis.label.get_window_extent().x0 > 0


def test_the_scale_of_residuals_says_that_it_is_logarithmic_and_numbers_its_decades():
    def numbers(furthest, few=False):
        style.scale_by_noise(ax := Figure().subplots(), furthest, few)
        return [text.get_text() for text in ax.get_yticklabels()]

    assert numbers(5) == ["−3", "0", "3"]
    assert numbers(92) == ["−10", "−3", "0", "3", "10"]
    assert numbers(2000)[-4:] == ["3", "10", "100", "1000"]
    assert numbers(2000, few=True)[-4:] == ["3", "", "100", "1000"]
    (page,), _ = quality.draw(tree := record(n_runs=1), fits(tree))
    assert page.axes[1].get_ylabel().endswith("log beyond ±3")


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


def test_every_axis_is_labelled_with_its_unit_and_nothing_overlaps(datasets):
    records, fitted = datasets
    figures = [foundation_effect.draw(records, "simulated", LABELS)[0]]
    figures += [comparison.draw(fitted[:2], runs_table(records), "simulated", LABELS)[0]]
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


def test_each_figure_has_the_width_of_a_page_and_nothing_overlaps(datasets):
    tables = runs_table(datasets[0]), restitution_table(*datasets), epsilon_table(datasets[1])
    drawings = {
        "foundation": lambda: foundation_effect.draw(datasets[0], "simulated", LABELS),
        "comparison": lambda: comparison.draw(datasets[1][:2], runs_table(datasets[0]), "simulated", LABELS),
        "restitution": lambda: restitution.draw(*tables, BLOCKS, "simulated", LABELS),
        "predictions": lambda: predictions.draw(predicted(), "simulated", LABELS),
    }
    for name, draw in drawings.items():
        figure, _ = draw()
        assert figure.get_figwidth() == style.WIDTH_IN
        assert_nothing_overlaps(figure, name)
        shrinks = min(6.5 / figure.get_figwidth(), 6.28 / figure.get_figheight())  # on a page of `article`
        assert shrinks * min(text.get_fontsize() for text in figure.findobj(Text)) >= 7, name


def predicted():
    """A table of bands of two runs in two scenes, made up."""
    rows = [
        {"block": "b1", "foundation": base, "test": f"b1_{base}", "run": run, "model": "hunt_crossley"}
        | {"peak": n, "peak_deg": 8.0 / n + 0.1 * run, "low_deg": 7.0 / n, "high_deg": 9.0 / n}
        | {"median_deg": 8.0 / n, "inside": 7.0 / n <= 8.0 / n + 0.1 * run <= 9.0 / n}
        for base in ("marble", "mat")
        for run in (1, 2)
        for n in range(1, 9)
    ]
    return pd.DataFrame(rows)


def test_predictions_draw_the_band_of_the_run_with_most_peaks_and_the_peaks_of_all():
    table = predicted()
    figure, data = predictions.draw(table, "simulated", LABELS)
    assert len(figure.axes) == 2 and data is table
    (band,) = figure.axes[0].collections
    np.testing.assert_allclose(band.get_paths()[0].vertices[:, 1].min(), 7 / 8)
    _, *runs = figure.axes[0].lines
    np.testing.assert_allclose(runs[1].get_ydata(), 8.0 / np.arange(1, 9) + 0.2)
    assert "Law: Hunt–Crossley. " in predictions.caption(data)
    assert f"{table['inside'].sum()} of 32 peaks" in predictions.caption(data)
    empty, none = predictions.draw(table[:0], "simulated")
    assert any("nothing is predicted" in text for text in texts(empty))
    assert "Band" in predictions.caption(data) and "Band" not in predictions.caption(none)


def test_predictions_of_runs_of_one_peak_have_no_band_and_name_none():
    table = predicted()
    shortened = table[(table["run"] == 2) | (table["peak"] == 1)]
    figure, _ = predictions.draw(shortened, "simulated")
    assert len(figure.axes[0].collections) == 1 and len(figure.axes[0].lines[0].get_xdata()) == 8
    figure, _ = predictions.draw(table[table["peak"] == 1], "simulated")
    assert not figure.axes[0].collections
    assert legend(figure) == ["simulated record: run 1", "run 2"]


@given(st.lists(st.floats(-1e3, 1e3) | st.just(np.nan), max_size=300), st.integers(1, 50))
def test_extremes_keep_the_highest_and_lowest_sample(values, n_bins):
    kept = extremes(values, n_bins)
    assert len(kept) <= 2 * n_bins
    assert np.all(np.diff(kept) > 0)
    finite = np.array(values)[np.isfinite(values)] if values else []
    if len(finite):
        shown = np.array(values)[kept]
        assert (np.nanmin(shown), np.nanmax(shown)) == (min(finite), max(finite))


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_of_a_campaign_is_a_module_that_draws_and_captions(name):
    module = import_module(f"freerock.figures.{name}")
    draw = inspect.signature(module.draw)
    assert {"origin", "labels"} < set(draw.parameters)
    assert [*inspect.signature(module.caption).parameters] == ["data", "labels"]
    assert {*getattr(module, "READS", {})} == {"records", "fits"} & {*entry_of(name)["reads"]}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("step", "needless"),
    [
        ("freerock.jobs.make_figure, freerock.figures.restitution", {"xarray", "scipy", "netCDF4"}),
        ("freerock.jobs.make_quality", {"scipy", "numba", "pydantic"}),
        ("freerock.jobs.make_report", {"xarray", "scipy", "matplotlib"}),
    ],
)
def test_a_step_that_draws_or_reports_loads_no_library_that_it_does_not_need(step, needless):
    code = f"import sys, {step}; print(*{needless} & {{*sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_a_png_has_few_colours_and_pure_black_and_white(tmp_path):
    figure = Figure()
    figure.subplots().plot([0, 1], [0, 1], "k", linewidth=9)
    style.save(figure, pd.DataFrame({"x": [0, 1]}), tmp_path / "line")
    with Image.open(tmp_path / "line.png") as picture:
        colours = {colour for _, colour in picture.convert("RGB").getcolors()}
    assert {(0, 0, 0), (255, 255, 255)} < colours and len(colours) <= style.COLOURS
