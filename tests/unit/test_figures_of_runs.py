"""Figures of runs: parameters, period, restitution, residuals."""

import inspect
import re
from dataclasses import asdict
from importlib import import_module

import numpy as np
import pytest
from fabricated import RATE_HZ, campaign, fits, record, tidy_tables
from matplotlib.colors import to_hex
from matplotlib.path import Path as MplPath
from test_figures import BLOCKS, LABELS, texts

from freerock.figures import listed, parameters, residuals, restitution
from freerock.figures.listed import FIGURES
from freerock.jobs.make_figure import make_figure
from freerock.tables.csvfile import write_csv
from freerock_bench.gallery import program


@pytest.fixture(scope="module")
def tables():
    return tidy_tables(*campaign())


def of_swings(tables):
    return tables["runs"], tables["restitution"], tables["epsilon"], BLOCKS, "simulated", LABELS


def test_each_figure_has_a_title_and_a_caption():
    for name in FIGURES:
        assert {*listed.entry_of(name)} == {"title", "caption", "reads"}


def test_the_gallery_s_programs_take_what_a_figure_reads():
    for name in FIGURES:
        reads = listed.entry_of(name)["reads"]
        draw = inspect.signature(import_module(f"freerock.figures.{name}").draw)
        assert list(draw.parameters) == [*reads, "origin", "labels"], name
        compile(program(name), name, "exec")
        assert len(program(name).replace("\n\n", "\n").splitlines()) <= 10, name


def test_parameters_have_a_row_per_run_record_and_foundation(tables):
    drawn = [tables[name] for name in ("parameters", "populations", "choice")]
    figure, data = parameters.draw(*drawn, "simulated", LABELS)
    assert set(data["model"]) == {"hunt_crossley"}
    assert data.groupby("level")["parameter"].count().to_dict() == {"run": 14, "record": 8, "foundation": 4}
    own = data[(data["level"] == "run") & (data["parameter"] == "k")]
    np.testing.assert_allclose(own["value"], 6.88e6)
    assert {"Slender block", "all records"} <= {*texts(figure)}
    assert [ax.get_title(loc="left") for ax in figure.axes[::3]] == ["(a) Marble", "(b) mat"]
    told = parameters.caption(data)
    assert told.startswith("Law: Hunt–Crossley, selected for 7 of 7 runs. 4 records. ")
    assert all(word in told for word in ("Circles", "Squares", "ellipse"))


def test_parameters_explain_only_markers_that_are_drawn(tables):
    choice = tables["choice"][tables["choice"]["test"] == "b2_mat"]  # its one run has no row beside the mean
    means = tables["populations"][tables["populations"]["level"] == "record"]
    _, data = parameters.draw(tables["parameters"], means, choice, "simulated")
    told = parameters.caption(data[data["test"] == "b2_mat"])
    assert "Diamonds" in told and not any(word in told for word in ("Circles", "Squares"))


def test_ellipses_have_the_colour_of_their_record_s_name(tables):
    drawn = [tables[name] for name in ("parameters", "populations", "choice")]
    figure, _ = parameters.draw(*drawn, "simulated", LABELS)
    names, ellipses = figure.axes[0].get_yticklabels(), figure.axes[2].lines
    assert len({to_hex(line.get_color()) for line in ellipses}) == 2
    assert to_hex(ellipses[0].get_color()) == to_hex(names[0].get_color())
    assert to_hex(ellipses[-1].get_color()) == to_hex(names[-2].get_color())


def test_an_ellipse_holds_95_percent_and_is_as_tilted_as_its_correlation():
    rng, covariance = np.random.default_rng(1), np.array([[4.0, 5.4], [5.4, 9.0]])
    x, y = parameters.ellipse(2.0, 3.0, 0.9, np.linspace(0, 2 * np.pi, 400))
    inside = MplPath(np.column_stack([x, y])).contains_points(
        rng.multivariate_normal([0, 0], covariance, 20_000)
    )
    assert inside.mean() == pytest.approx(0.95, abs=0.005)


def bars_of(ax):
    """Both ends of each bar, of each series with errors: [x, y]."""
    return [np.array(each.lines[2][0].get_segments()) for each in ax.containers]


def test_bars_of_parameters_are_95_percent_of_their_total_uncertainty(tables):
    figure, data = parameters.draw(
        tables["parameters"], tables["populations"], tables["choice"], "simulated", LABELS
    )
    of_k = data[(data["parameter"] == "k") & (data["foundation"] == "marble")]
    for bars, level in zip(bars_of(figure.axes[0]), ("run", "record", "foundation"), strict=True):
        own = of_k[of_k["level"] == level]
        half = 1.959964 * own["u"]
        ends = np.column_stack([own["value"] - half, own["value"] + half])
        np.testing.assert_allclose(np.sort(bars[:, :, 0], axis=0), np.sort(ends, axis=0), rtol=1e-6)


def test_parameters_are_of_the_law_of_each_foundation(tables):
    """On marble Housner is named, on the mat Hunt–Crossley for one of two blocks."""
    choice = tables["choice"].copy()
    named = np.where(choice["foundation"] == "marble", "housner", "hunt_crossley")
    selected = (choice["model"] == named) & (choice["test"] != "b2_mat")
    choice["status"] = np.where(selected, "selected", "rejected")
    figure, data = parameters.draw(tables["parameters"], tables["populations"], choice, "simulated", LABELS)
    laws = data.groupby("foundation")["model"].unique().map(list).to_dict()
    assert laws == {"marble": ["housner"], "mat": ["hunt_crossley"]}
    assert set(data[data["foundation"] == "mat"]["parameter"]) == {"k", "lambda"}
    assert data[data["test"] == "b2_mat"].query("level == 'run'")["rejected"].all()
    assert [ax.get_xlabel() for ax in figure.axes if ax.axison] == [
        "restitution r",
        "k / (N m⁻²)",
        "λ / (N s m⁻³)",
        "k / (N m⁻²)",
    ]
    on_marble, on_mat, *_ = parameters.caption(data, LABELS).removeprefix("Laws: ").split("; ")
    assert re.fullmatch(r"Housner \(Marble\), selected for (\d) of \1 runs", on_marble)
    assert re.match(r"Hunt–Crossley \(mat\), selected for \d of \d runs\. ", on_mat)


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


def test_a_caption_has_a_title_what_is_drawn_of_which_runs_and_that_it_is_simulated(tables, tmp_path):
    files = [tmp_path / f"{name}.csv" for name in ("runs", "restitution", "epsilon")]
    for file in files:
        write_csv(tables[file.stem], file)
    settings = {"origin": "simulated", "labels": LABELS, "scenes": [], "set_ups": {}}
    settings["blocks"] = {name: asdict(block) for name, block in BLOCKS.items()}
    files = {"records": [], "fits": [], "tables": files}
    make_figure(restitution, settings, files, tmp_path / "restitution")
    title, told = (tmp_path / "restitution.txt").read_text(encoding="utf-8").splitlines()
    assert title == "Restitution of each impact, from peaks."
    assert told.endswith(
        " 28 impacts of 7 runs. The records are simulated; they are not the laboratory's data."
    )
    assert re.findall(rb"/Count (\d+)", (tmp_path / "restitution.pdf").read_bytes()) == [b"1"]
