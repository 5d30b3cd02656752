"""Figures that a campaign asks for: parameters, period, energy, phase, residuals, evidence, budget, parts,
pulls.
"""

import inspect
import math
import re
from dataclasses import asdict
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from fabricated import RATE_HZ, campaign, failed_record, fits, record, tidy_tables
from overlaps import assert_nothing_overlaps
from test_figures import BLOCKS, LABELS, texts

from freerock.config.figure_names import FIGURES
from freerock.config.keys_of_campaign import CampaignFile
from freerock.figures import (
    backbone,
    budget,
    energy,
    evidence,
    overturning,
    parameters,
    parts,
    phase_portrait,
    pulls,
    residuals,
    restitution,
    style,
)
from freerock.jobs.figure_pages import HIGHEST_MM
from freerock.jobs.figure_pages import pages as in_pages
from freerock.jobs.make_figures import make_figures
from freerock.populations.estimate import Estimate
from freerock.populations.predict import PREDICTIONS
from freerock.products.misfit_maps import record_map
from freerock.response.motions import INTENSITIES
from freerock.tables.csvfile import write_csv
from freerock.tables.latex import figures_tex

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def tables():
    return tidy_tables(*campaign())


def of_swings(tables):
    return tables["runs"], tables["restitution"], tables["epsilon"], BLOCKS, "simulated", LABELS


def test_each_figure_of_the_configuration_is_a_module_and_the_first_are_those_of_the_report():
    for name in FIGURES:
        declared = import_module(f"freerock.figures.{name}").FIGURE
        assert {"title", "caption", "reads"} <= {*declared} <= {"title", "caption", "reads", "reading"}
        if name in CampaignFile.model_fields["figures"].default:
            assert len(re.findall(r"[^.]\.(?= |$)", declared["reading"])) == 3
            assert (ROOT / f"docs/images/report_{name}.png").stat().st_size > 1000
    default = CampaignFile.model_fields["figures"].default
    assert FIGURES[: len(default)] == default


def test_parameters_have_a_row_per_run_record_and_foundation(tables):
    drawn = [tables[name] for name in ("parameters", "populations", "choice")]
    figure, data = parameters.draw(*drawn, "simulated", LABELS)
    assert set(data["model"]) == {"hunt_crossley"}
    assert data.groupby("level")["test"].count().to_dict() == {"run": 12, "record": 8, "foundation": 4}
    alone = tables["runs"][~tables["runs"]["excluded"]].groupby("test")["run"].nunique() == 1
    assert alone.any() and not set(alone.index[alone]) & set(data[data["level"] == "run"]["test"])
    own = data[(data["level"] == "run") & (data["parameter"] == "k")]
    np.testing.assert_allclose(own["value"], 6.88e6)
    np.testing.assert_allclose(own["high"] - own["low"], 2 * 1.96 * 1.2e4)
    assert "Slender block, Marble" in texts(figure)
    assert parameters.caption(data) == "Law: Hunt–Crossley, named by 7 of 7 runs. Runs of 4 records."


def bars_of(ax):
    """Both ends of each bar, of each series with errors: [x, y]."""
    return [np.array(each.lines[2][0].get_segments()) for each in ax.containers]


def test_bars_of_parameters_reach_from_their_low_to_their_high_end(tables):
    own = tables["parameters"]
    own = own.assign(ci95_high=own["value"] + 3 * own["stderr"])
    figure, data = parameters.draw(own, tables["populations"], tables["choice"], "simulated", LABELS)
    ax, of_k = figure.axes[0], data[(data["parameter"] == "k") & (data["foundation"] == "marble")]
    for bars, level in zip(bars_of(ax), ("run", "record", "foundation"), strict=True):
        ends = of_k[of_k["level"] == level][["low", "high"]]
        np.testing.assert_allclose(bars[:, :, 0], ends)
    (next_runs,) = (line for line in ax.lines if line.get_label() == parameters.NEXT["record"])
    spans = of_k[of_k["level"] == "record"][["next_low", "next_high"]]
    np.testing.assert_array_equal(np.reshape(next_runs.get_xdata(), (-1, 3))[:, :2], spans)


def test_bars_of_counted_shares_reach_from_their_low_to_their_high_end():
    place = {
        "test": "t",
        "block": "b1",
        "foundation": "mat",
        "kind": "counted",
        "measure": next(iter(INTENSITIES)),
    }
    ends = {"low": [0.1, 0.3], "high": [0.5, 0.6], "n_motions": 9, "n_failed": 0}
    shares = pd.DataFrame(place | {"intensity": [1.0, 2.0], "probability": [0.2, 0.4]} | ends)
    figure, _ = overturning.draw(shares, "simulated", LABELS)
    np.testing.assert_allclose(bars_of(figure.axes[0])[0][:, :, 1], shares[["low", "high"]])


def test_parameters_are_of_the_law_of_each_foundation(tables):
    """On marble Housner is named, on the mat Hunt–Crossley for one of two blocks."""
    choice = tables["choice"].copy()
    named = np.where(choice["foundation"] == "marble", "housner", "hunt_crossley")
    selected = (choice["model"] == named) & (choice["test"] != "b2_mat")
    choice["status"] = np.where(selected, "selected", "rejected")
    figure, data = parameters.draw(tables["parameters"], tables["populations"], choice, "simulated", LABELS)
    laws = data.groupby("foundation")["model"].unique().map(list).to_dict()
    assert laws == {"marble": ["housner"], "mat": ["hunt_crossley"]}
    assert "b2_mat" not in set(data["test"]) and set(data[data["foundation"] == "mat"]["parameter"]) == {
        "k",
        "lambda",
    }
    assert [ax.get_xlabel() for ax in figure.axes if ax.axison] == [
        "restitution r",
        "k / (N m⁻²)",
        "λ / (N s m⁻³)",
    ]
    on_marble, on_mat = parameters.caption(data, LABELS).removeprefix("Laws: ").split("; ")
    assert re.fullmatch(r"Housner \(Marble\), named by (\d) of \1 runs", on_marble)
    assert re.match(r"Hunt–Crossley \(mat\), named by \d of \d runs\. Runs of ", on_mat)


def test_a_spread_that_is_nothing_was_not_seen(tables):
    populations = tables["populations"].assign(tau=0.0, tau_high=0.0, scatter_p=1.0)
    figure, data = parameters.draw(tables["parameters"], populations, tables["choice"], "simulated", LABELS)
    assert set(data["tau_text"].dropna()) <= {"", "not seen"} and "not seen" in texts(figure)
    assert "not seen where noise explains all of it" in parameters.FIGURE["caption"]


def test_parameters_of_a_rejected_law_are_open(tables):
    choice = tables["choice"].assign(status="rejected")
    drawn = [tables["parameters"], tables["populations"], choice]
    _, data = parameters.draw(*drawn, "simulated", LABELS)
    assert data[data["level"] == "run"]["rejected"].all()


def test_of_many_runs_the_records_are_drawn(tables, monkeypatch):
    monkeypatch.setattr(parameters, "MOST_ROWS", 8)
    drawn = [tables[name] for name in ("parameters", "populations", "choice")]
    _, data = parameters.draw(*drawn, "simulated", LABELS)
    assert set(data["level"]) == {"record", "foundation"}


def test_of_hundreds_of_records_some_of_each_block_stand_on_one_page(tables):
    names = ["parameters", "populations", "choice"]
    copies = {
        name: pd.concat([tables[name].assign(test=tables[name]["test"] + f"_{i}") for i in range(100)])
        for name in names
    }
    (drawn,) = in_pages(lambda **taken: parameters.draw(**taken, origin="simulated", labels=LABELS), copies)
    figure, data = drawn
    records = data[data["level"] == "record"]
    assert 25.4 * figure.get_figheight() <= HIGHEST_MM
    assert records["test"].nunique() == parameters.MOST_RECORDS and set(records["block"]) == {"b1", "b2"}
    assert (records.groupby("foundation")["test"].nunique() == parameters.MOST_RECORDS // 2).all()


def test_nothing_to_draw_is_said():
    tree = failed_record()
    empty = tidy_tables([tree], [fits(tree)])
    drawn = [empty[name] for name in ("parameters", "populations", "choice")]
    figure, data = parameters.draw(*drawn, "simulated", LABELS)
    assert data.empty and "no run has a fit that may be used" in texts(figure)
    figure, data = evidence.draw(empty["choice"], "simulated", LABELS)
    assert data.empty and "no candidate was fitted" in texts(figure)
    figure, data = parts.draw(empty["parts"], empty["parameters"], empty["choice"], "simulated", LABELS)
    assert data.empty and "no run has a fit that may be used" in texts(figure)
    figure, data = budget.draw(empty["budget"], empty["choice"], "simulated", LABELS)
    assert data.empty and "no mean has a budget" in texts(figure)
    for module in (backbone, energy):
        figure, data = module.draw(*of_swings(empty))
        assert data.empty
        figure.draw_without_rendering()
    figure, data = phase_portrait.draw([fits(tree)], empty["epsilon"], "simulated", LABELS)
    assert data.empty and "no fitted run" in texts(figure)
    figure, data = residuals.draw([fits(tree)], [tree], "simulated", LABELS)
    assert data.empty and "no fitted run" in texts(figure)


def test_the_models_of_the_backbone_are_of_the_first_run(tables):
    figure, data = backbone.draw(*of_swings(tables))
    modelled = data[data["source"] != "experiment"]
    assert set(modelled["run"]) == {1}
    assert set(data[data["source"] == "experiment"]["run"]) == {1, 2}
    np.testing.assert_allclose(data["period_s"], 0.8)  # impacts every 0.4 s
    assert [ax.get_xlabel() for ax in figure.axes] == ["amplitude |θ|/α"] * 2


def test_energy_is_of_the_first_run_and_the_model_that_stands_for_it(tables):
    figure, data = energy.draw(*of_swings(tables))
    assert set(data["source"]) == {"experiment", "hunt_crossley"}
    assert set(data["run"]) == {1}
    assert energy.caption(data).endswith(" Model: Hunt–Crossley.")
    seen = data[(data["source"] == "experiment") & (data["block"] == "b1") & (data["foundation"] == "marble")]
    ends = 100 * np.column_stack([seen["loss"] - seen["loss_u"], seen["loss"] + seen["loss_u"]])
    np.testing.assert_allclose(bars_of(figure.axes[1])[0][:, :, 1], ends)
    assert style.FOOTER in texts(figure)


def test_bars_of_restitutions_are_their_total_uncertainty(tables):
    figure, data = restitution.draw(*of_swings(tables))
    seen = data[(data["source"] == "experiment") & (data["block"] == "b1") & (data["foundation"] == "marble")]
    assert (seen["r_u"] > seen["r_stderr"]).all()
    ends = np.column_stack([seen["r"] - seen["r_u"], seen["r"] + seen["r_u"]])
    np.testing.assert_allclose(bars_of(figure.axes[0])[0][:, :, 1], ends)


def test_the_phase_portrait_has_the_rate_of_the_motion(tables):
    _, data = phase_portrait.draw(campaign()[1][:1], tables["epsilon"], "simulated", LABELS)
    assert set(data["source"]) == {"measured", "hunt_crossley"}
    own = data[(data["source"] == "hunt_crossley") & data["time_s"].between(0.05, 3.9)]
    t, angle, w = own["time_s"], 10.1, 2 * np.pi * 1.2
    rate = angle * np.exp(-t / 1.5) * (-np.cos(w * t) / 1.5 - w * np.sin(w * t))
    np.testing.assert_allclose(own["rate_deg_s"], rate, atol=0.3)


def test_the_spectrum_of_a_residual_of_white_noise_is_that_of_its_variance():
    tree = record("b1_mat", "b1", "mat")
    figure, data = residuals.draw([fits(tree)], [tree], "simulated", LABELS)
    own = data[data["source"] == "hunt_crossley"]
    highest = own[own["run"] == 1].iloc[-1]
    assert highest["density_deg2_hz"] == pytest.approx(0.01**2 / (RATE_HZ / 2), rel=0.15)
    assert RATE_HZ / 4 < highest["frequency_hz"] < RATE_HZ / 2
    assert figure.axes[0].get_title(loc="left") == "Slender block, mat"


def test_a_law_that_is_rejected_leaves_the_band_of_chance_and_one_that_explains_does_not():
    tree, own = record("b1_mat", "b1", "mat"), {}
    for case in ("noise", "zero off", "law off"):
        fitted = fits(tree)
        residual = fitted["run_1/hunt_crossley"]["residual"].values
        time_s = fitted["run_1"]["time"].values
        residual += {"noise": 0, "zero off": 1e-3, "law off": 1e-3 * np.sin(40 * time_s)}[case]
        figure, data = residuals.draw([fitted], [tree], "simulated", LABELS)
        data = data[data["run"] == 1].pivot(index="frequency_hz", columns="source", values="over_rest")
        own[case] = (data["hunt_crossley"] / data[residuals.CHANCE]).max()
        low, high = figure.axes[0].get_ylim()
        assert low < 1 and high > 10  # both have a number
    assert own["noise"] < 1 < own["law off"]
    assert own["zero off"] == pytest.approx(own["noise"])


def test_evidence_shows_each_fitted_candidate_of_each_run(tables):
    figure, data = evidence.draw(tables["choice"], "simulated", LABELS)
    assert len(data) == tables["choice"]["noise_ratio"].notna().sum() > 0
    assert "Hunt–Crossley" in texts(figure)
    assert evidence.caption(data) == "7 runs of 4 records."


def test_parts_of_a_run_are_drawn_over_the_whole(tables):
    figure, data = parts.draw(tables["parts"], tables["parameters"], tables["choice"], "simulated", LABELS)
    assert set(data["model"]) == {"hunt_crossley"}
    k = data[data["parameter"] == "k"]
    np.testing.assert_allclose(k["change_percent"], np.tile([1.0, 0.0], len(k) // 2), atol=1e-9)
    np.testing.assert_allclose(k["change_stderr_percent"], 100 * 1.2e4 / 6.88e6)
    assert figure.axes[0].get_title(loc="left") == "(a) Slender block, Marble"
    assert parts.caption(data) == "7 runs of 4 records."


def test_the_budget_stacks_shares_and_names_defaults(tables):
    key = {"campaign": "c", "level": "record", "test": "a", "block": "b1", "foundation": "mat"}
    key |= {"model": "hunt_crossley", "parameter": "k", "mean": 5e6, "u_total": 1e5}
    shares = {"runs": (70.0, pd.NA), "width_m": (20.0, 0), "position_m": (10.0, 1)}
    rows = [
        {**key, "input": name, "share_percent": share, "input_stated": stated}
        for name, (share, stated) in shares.items()
    ]
    figure, data = budget.draw(pd.DataFrame(rows), tables["choice"], "simulated", LABELS)
    bars = figure.axes[0].patches
    assert [bar.get_width() for bar in bars] == [70.0, 20.0, 10.0]
    assert [bar.get_x() for bar in bars] == [0.0, 70.0, 90.0]
    assert "u = 2 %" in texts(figure)
    more = pd.DataFrame([*rows, *(row | {"test": "a_2"} for row in rows)])
    names = budget.draw(more, tables["choice"], "simulated", LABELS)[0].axes[0].get_yticklabels()
    assert [name.get_text() for name in names] == ["Slender block, mat: a", "Slender block, mat: a_2"]
    assert (
        budget.caption(data)
        == "Law: Hunt–Crossley, named by 7 of 7 runs. Taken by default, not stated: width."
    )


def test_pulls_stand_beside_the_impacts_of_their_inputs(tables):
    first = tables["choice"].loc[tables["choice"]["status"] == "selected"].iloc[0]
    key = {name: first[name] for name in ("campaign", "test", "run", "block", "foundation", "model")}
    moved = {"width_m": (1.5, 0.6, 1.9, -0.8), "position_m": (-0.2, 1.0, math.nan, 0.01)}
    rows = [
        {**key, "input": name, "input_owner": "b1", "input_stated": name == "width_m", "input_moved": shift}
        | {"input_remaining": left, "input_pull": pull, "impact_k_percent": impact}
        | dict.fromkeys((f"impact_{other}_percent" for other in ("r", "c", "lambda", "kappa")), math.nan)
        for name, (shift, left, pull, impact) in moved.items()
    ]
    figure, data = pulls.draw(pd.DataFrame(rows), tables["choice"], "simulated", LABELS)
    left, right = figure.axes
    assert left.get_yticklabels()[0].get_text() == "width, Slender block"
    assert list(data["input"]) == ["width_m", "position_m"]
    assert [bar.get_width() for bar in right.patches] == [-0.8, 0.01]
    assert sorted(float(line.get_xdata()[0]) for line in left.lines if line.get_marker() == "o") == [
        -0.2,
        1.5,
    ]
    told = "Fits of 1 run; 2 inputs, 1 of them with a default uncertainty."
    told += " Largest pull: +1.9, of the width of b1."
    assert pulls.caption(data) == told
    empty = pulls.draw(pd.DataFrame(rows)[:0], tables["choice"], "simulated", LABELS)
    assert "no run moved its inputs" in texts(empty[0]) and pulls.caption(empty[1]).startswith(
        "No run has a fit of its selected law"
    )


def test_captions_are_latex_figures():
    told = {
        "models_a": ("Rotation of A_1 & B", "ε_θ is below 3 σ; 5 % of ±1.96 σ."),
        "restitution": ("R", "r²"),
    }
    text = figures_tex(told)
    assert text.count(r"\begin{figure}") == text.count(r"\end{figure}") == 2
    assert r"\includegraphics[width=\linewidth]{models_a}" in text
    assert r"\caption{\textbf{Rotation of A\_1 \& B} $\varepsilon_\theta$ is below 3 $\sigma$; " in text
    assert r"; 5 \% of $\pm$1.96 $\sigma$.}" in text
    assert text.count(r"\label{fig:models_a}") == 1
    assert not re.search(r"[^\x00-\x7f]", text)


def pages(stem):
    return int(re.search(rb"/Count (\d+)", stem.with_suffix(".pdf").read_bytes())[1])


def made(tmp_path, tables, module, names, target, blocks=BLOCKS, **more):
    """A figure of a campaign, from the files of its tables; its settings are those of the workflow."""
    for name in names:
        write_csv(tables[name], tmp_path / f"{name}.csv")
    files = {name: str(tmp_path / f"{name}.csv") for name in names} | more
    settings = {"origin": "simulated", "labels": LABELS, "title": "Title", "caption": "What is drawn."}
    settings |= {
        "scenes": [*more.get("fits", ())],
        "blocks": {name: asdict(block) for name, block in blocks.items()},
    }
    name = module.__name__.rpartition(".")[2]
    make_figures([module], files, {name: settings}, tmp_path, target)
    return tmp_path / name


def test_a_caption_has_a_title_what_is_drawn_of_which_runs_and_that_it_is_simulated(tables, tmp_path):
    stem = made(tmp_path, tables, restitution, ["runs", "restitution", "epsilon"], "double_column")
    assert stem.with_suffix(".txt").read_text(encoding="utf-8") == (
        "Title.\nWhat is drawn. 28 impacts of 7 runs. Lines: the law fitted to the first run, Hunt–Crossley. "
        "The records are simulated; they are not the laboratory's data.\n"
    )
    assert pages(stem) == 1


def test_a_slide_shows_a_block_and_of_one_block_a_foundation(tables, tmp_path, monkeypatch):
    assert pages(made(tmp_path, tables, restitution, ["runs", "restitution", "epsilon"], "slide")) == 2
    assert pages(made(tmp_path, tables, parameters, ["parameters", "populations", "choice"], "slide")) == 2
    trees = dict(zip("abcd", campaign()[1], strict=False))
    monkeypatch.setattr("freerock.products.netcdf.open_fits", lambda path, only: trees[path])
    stem = made(tmp_path, tables, phase_portrait, ["epsilon"], "slide", fits=["a", "b", "c", "d"])
    assert pages(stem) == 2
    whole = made(tmp_path, tables, phase_portrait, ["epsilon"], "double_column", fits=["a", "b", "c", "d"])
    one, other = (pd.read_csv(each.with_suffix(".csv")) for each in (stem, whole))
    assert len(one) == len(other)
    settings = tables | {"epsilon": of_block(tables["epsilon"])}
    assert pages(made(tmp_path, settings, phase_portrait, ["epsilon"], "slide", fits=["a", "b"])) == 2


@pytest.mark.parametrize("target", ["double_column", "single_column"])
def test_no_page_is_higher_than_a_journals_and_every_block_is_on_one(tables, tmp_path, target):
    names = [f"b{i}" for i in range(1, 13)]
    many = {
        name: pd.concat([of_block(tables[name]).assign(block=each) for each in names], ignore_index=True)
        for name in ("runs", "restitution", "epsilon")
    }
    stem = made(tmp_path, many, restitution, [*many], target, blocks=dict.fromkeys(names, BLOCKS["b1"]))
    boxes = re.findall(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", stem.with_suffix(".pdf").read_bytes())
    heights_mm = [25.4 / 72 * float(height) for _, height in boxes]
    assert len(heights_mm) > 1 and max(heights_mm) <= HIGHEST_MM
    assert set(pd.read_csv(stem.with_suffix(".csv"))["block"]) == {*names}


@pytest.fixture(scope="module")
def of_many_blocks(tables):
    """What figures take, by name, of a campaign of eight blocks, each with the records of b1."""
    names = [f"b{i}" for i in range(1, 9)]

    def frame(own, block):
        if "test" in own:
            own = own.assign(test=own["test"].where(own["test"].isna(), own["test"] + f"_{block}"))
        return own.assign(block=block)

    def tree(own, block):
        copy = own.copy()
        copy.attrs |= {"block": block, "test": f"{own.attrs['test']}_{block}"}
        return copy

    known = {
        kind: pd.concat([frame(of_block(own), each) for each in names], ignore_index=True)
        if "block" in own
        else own
        for kind, own in tables.items()
    }
    trees = [[each for each in kind if each.attrs["block"] == "b1"] for kind in campaign()]
    records, fitted = ([tree(own, each) for each in names for own in kind] for kind in trees)
    set_up = {"foundations": ["marble", "mat"], "lasers": []}
    bases = [known["epsilon"].assign(n_runs=2, basis=basis) for basis in ("other runs", "b2")]
    misfit = xr.Dataset(
        {
            "epsilon_theta": (("lambda", "k"), np.eye(3)),
            "epsilon_finer": (("lambda_finer", "k_finer"), np.eye(5)),
        },
        {name: np.arange(1.0, 4.0) for name in ("k", "lambda")}
        | {f"{name}_finer": np.ones(5) for name in ("k", "lambda")},
    )
    maps = [
        record_map(
            misfit,
            [
                Estimate(
                    "made_up",
                    each.attrs["test"],
                    1,
                    each.attrs["block"],
                    each.attrs["foundation"],
                    "hunt_crossley",
                    {"k": 2.0, "lambda": 2.0},
                    np.eye(2),
                )
            ],
        )
        for each in fitted
    ]
    curve = [
        {"test": f"t_{block}", "block": block, "foundation": "mat", "measure": measure, "kind": kind}
        | {"intensity": 0.1 * i, "probability": 0.1 * i, "low": 0.05 * i, "high": 0.1 * i}
        | {"n_motions": 9, "n_failed": 0}
        for block in names
        for measure in INTENSITIES
        for kind in ("fitted", "counted")
        for i in range(1, 9)
    ]
    return known | {
        "fragility": pd.DataFrame(curve),
        "predictions": pd.concat(bases, ignore_index=True)[PREDICTIONS],
        "maps": maps,
        "records": records,
        "fits": fitted,
        "blocks": dict.fromkeys(names, BLOCKS["b1"]),
        "set_ups": dict.fromkeys(names, set_up),
        "debonding": "geometric",
        "origin": "simulated",
        "labels": LABELS,
    }


@pytest.mark.slow
@pytest.mark.parametrize("target", ["double_column", "single_column"])
@pytest.mark.parametrize("name", FIGURES)
def test_no_figure_is_higher_than_a_journals_page(of_many_blocks, name, target):
    module = import_module(f"freerock.figures.{name}")
    taken = {key: of_many_blocks[key] for key in inspect.signature(module.draw).parameters if key != "target"}
    drawn = in_pages(partial(module.draw, target=target), taken)
    assert max(25.4 * figure.get_figheight() for figure, _ in drawn) <= HIGHEST_MM
    width_mm = {"double_column": 178, "single_column": 89}[target]
    assert max(25.4 * figure.get_figwidth() for figure, _ in drawn) <= width_mm


@pytest.mark.slow
@pytest.mark.parametrize(
    ("target", "width_in"), [("single_column", 3.5), ("double_column", 7), ("slide", 10)]
)
def test_at_each_width_nothing_overlaps(tables, target, width_in):
    one = {name: of_block(frame) for name, frame in tables.items()} if target == "slide" else tables
    fitted = campaign()[1][:2]
    drawings = {
        "parameters": lambda: parameters.draw(
            one["parameters"], one["populations"], one["choice"], "simulated", LABELS, target=target
        ),
        "backbone": lambda: backbone.draw(*of_swings(one), target=target),
        "energy": lambda: energy.draw(*of_swings(one), target=target),
        "phase_portrait": lambda: phase_portrait.draw(
            fitted, one["epsilon"], "simulated", LABELS, target=target
        ),
        "residuals": lambda: residuals.draw(fitted, campaign()[0], "simulated", LABELS, target=target),
        "evidence": lambda: evidence.draw(one["choice"], "simulated", LABELS, target=target),
        "parts": lambda: parts.draw(
            one["parts"], one["parameters"], one["choice"], "simulated", LABELS, target=target
        ),
    }
    for name, draw in drawings.items():
        figure, _ = draw()
        assert figure.get_figwidth() == width_in
        assert_nothing_overlaps(figure, name)


def of_block(frame):
    return frame[frame["block"].isin(["b1", ""])] if "block" in frame else frame
