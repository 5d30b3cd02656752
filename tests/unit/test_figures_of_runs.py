"""Figures of runs: parameters, period, restitution, residuals."""

import re
from dataclasses import asdict
from importlib import import_module

import numpy as np
import pytest
from fabricated import RATE_HZ, campaign, fits, record, tidy_tables
from test_figures import BLOCKS, LABELS

from freerock.config.figure_names import FIGURES
from freerock.config.keys_of_campaign import CampaignFile
from freerock.figures import parameters, residuals, restitution
from freerock.jobs.make_figures import make_figures
from freerock.tables.csvfile import write_csv


@pytest.fixture(scope="module")
def tables():
    return tidy_tables(*campaign())


def test_each_figure_of_the_configuration_is_a_module_and_drawn_by_default():
    for name in FIGURES:
        declared = import_module(f"freerock.figures.{name}").FIGURE
        assert {*declared} == {"title", "caption", "reads", "reading"}
    assert CampaignFile.model_fields["figures"].default == FIGURES


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


def pages(stem):
    return int(re.search(rb"/Count (\d+)", stem.with_suffix(".pdf").read_bytes())[1])


def made(tmp_path, tables, module, names, blocks=BLOCKS, **more):
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
    make_figures([module], files, {name: settings}, tmp_path)
    return tmp_path / name


def test_a_caption_has_a_title_what_is_drawn_of_which_runs_and_that_it_is_simulated(tables, tmp_path):
    stem = made(tmp_path, tables, restitution, ["runs", "restitution", "epsilon"])
    assert stem.with_suffix(".txt").read_text(encoding="utf-8") == (
        "Title.\nWhat is drawn. 28 impacts of 7 runs. Lines: the law fitted to the first run, Hunt–Crossley. "
        "The records are simulated; they are not the laboratory's data.\n"
    )
    assert pages(stem) == 1
