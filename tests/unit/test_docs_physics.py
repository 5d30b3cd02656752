"""docs/equations.md: every formula has a source and a test that exists, every number is computed again."""

import ast
import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.identification.fit import fit_run
from freerock.models.block import Block
from freerock.models.contact import Foundation, static_depth
from freerock.models.housner import housner_swings
from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate, simulate_theta
from freerock.rotation.beam import rotation_from_displacement
from freerock.runs.impacts import find_impacts
from freerock.runs.motion import Motion
from freerock.virtual_lab.palermo import LASERS

ROOT = Path(__file__).parents[2]
PAGES = [(ROOT / f"docs/{name}.md").read_text(encoding="utf-8") for name in ("equations", "physics")]
DOCUMENT = "\n\n".join(PAGES)
BLOCKS = {1: Block(0.42, 0.07, 8.67), 2: Block(0.28, 0.07, 5.84), 3: Block(0.14, 0.07, 2.98)}
RELEASE_DEG = {1: 6, 2: 10, 3: 20}
PIVOTING = Rules(kinematics="pivoting")
TABLE2 = {
    ("hunt_crossley", "marble"): {"k": 6.88e6, "lambda": 1.30e8},
    ("hunt_crossley", "Aerstop"): {"k": 2.86e6, "lambda": 8.16e7},
    ("winkler", "marble"): {"k": 6.77e6, "c": 2.17e4},
    ("winkler", "Aerstop"): {"k": 4.50e6, "c": 4.05e4},
}
# a fenced block that begins with its number, and the paragraph right after it
FORMULA = re.compile(r"^```\n\(F(\d+)\) (.*?)^```\n(.*?)(?:\n\n|\Z)", re.MULTILINE | re.DOTALL)
TEST = re.compile(r"`(tests/[\w/]+\.py)::(\w+)`")


def formulas():
    """Number, source and tests of each formula of the document."""
    found = []
    for number, _, after in FORMULA.findall(DOCUMENT):
        source, _, tests = " ".join(after.split()).partition(" Test: ")
        found.append((int(number), source, TEST.findall(tests)))
    return found


def functions(path):
    return {node.name for node in ast.parse(path.read_text(encoding="utf-8")).body if hasattr(node, "name")}


def rows(header):
    """Cells of the rows of the table whose first line begins so."""
    lines = DOCUMENT[DOCUMENT.index(header) :].split("\n\n")[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def numbers(header):
    """The numbers of the table, a row each, names left out."""
    return [[float(c.replace("−", "-")) for c in row if re.match(r"[−\d.]", c)] for row in rows(header)]


def test_formulas_are_numbered_without_gaps():
    assert [number for number, _, _ in formulas()] == list(range(1, len(formulas()) + 1))
    assert len(formulas()) == len(re.findall(r"^\(F\d+\)  ", DOCUMENT, re.MULTILINE))
    assert f"(F1) to (F{len(formulas())})" in DOCUMENT
    mentioned = {int(number) for number in re.findall(r"\(F(\d+)\)", DOCUMENT)}
    assert mentioned == {number for number, _, _ in formulas()}


@pytest.mark.parametrize(
    ("number", "source", "tests"), formulas(), ids=lambda part: f"F{part}" if isinstance(part, int) else ""
)
def test_formula_has_a_source_and_a_test(number, source, tests):
    assert source.startswith("Source: ")
    assert re.search(r"doi:|eq|paper|derived here|least squares|this package", source, re.IGNORECASE), source
    assert tests, number
    for path, name in tests:
        assert name in functions(ROOT / path), f"{path}::{name}"


def test_every_test_named_exists():
    assert "TODO" not in DOCUMENT
    for path, name in TEST.findall(DOCUMENT):
        assert name in functions(ROOT / path), f"{path}::{name}"


@pytest.fixture(scope="module")
def drawing():
    sys.path.insert(0, str(ROOT / "docs/images"))
    import draw

    sys.path.pop(0)
    return draw


def test_figures_are_those_that_are_drawn(drawing):
    named = re.findall(r"!\[[^\]]{20,}\]\((images/\w+\.svg)\)", DOCUMENT)
    assert sorted(named) == sorted(f"images/{name}.svg" for name in drawing.FIGURES)
    for name in named:
        assert (ROOT / "docs" / name).read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.parametrize("name", re.findall(r"images/(\w+)\.svg", DOCUMENT))
def test_figure_can_be_drawn(drawing, name):
    assert drawing.FIGURES[name]().axes


def test_same_figures_same_bytes(drawing, tmp_path):
    for folder in ("once", "again"):
        (tmp_path / folder).mkdir()
        drawing.draw(tmp_path / folder, ["free_body"])
    once, again = (tmp_path / folder / "free_body.svg" for folder in ("once", "again"))
    assert once.read_bytes() == again.read_bytes()


def test_table_of_blocks():
    table = numbers("| configuration | 2h [m] |")
    assert len(table) == 3
    for number, height, width, mass, release, *constants in table:
        block = BLOCKS[int(number)]
        assert (height, width, mass) == (block.height_m, block.width_m, block.mass_kg)
        assert release == RELEASE_DEG[int(number)]
        expected = block.R, math.degrees(block.theta_cr), block.p, block.restitution_housner
        assert constants == pytest.approx(expected, abs=6e-6)


def test_times_of_rest():
    stated = re.findall(r"([\d.]+) s \(r = ([\d.]+)\)", DOCUMENT)
    assert len(stated) == 2
    for time, r in stated:
        rest_time = housner_swings(BLOCKS[2], float(r), math.radians(10)).rest_time
        assert rest_time == pytest.approx(float(time), abs=6e-5)


def pulled_share(model, block, parameters, theta0, span=1.2):
    """Share of the energy lost that leaves through forces f < 0, by strips of the base and of time."""
    time = np.linspace(0, span, 12001)
    found = simulate(model, block, parameters, time, theta0=theta0, solver=Solver(1e-9))
    k, c, lam = parameters["k"], parameters.get("c", 0.0), parameters.get("lambda", 0.0)
    u = block.b * ((np.arange(400) + 0.5) / 200 - 1)[:, None]
    depth = found.z_cb + u * np.sin(found.theta)
    rate = found.z_cb_rate + u * found.theta_rate * np.cos(found.theta)
    damping = np.where(depth > 0, (c + lam * depth) * rate, 0.0)
    force = np.where(depth > 0, k * depth, 0.0) + damping
    return np.sum(np.where(force < 0, force * rate, 0.0)) / np.sum(damping * rate)


@pytest.mark.parametrize("row", rows("| configuration | foundation | ε_θ, Hunt–Crossley"), ids=" ".join)
def test_table_of_debonding(row):
    number, foundation, *cells = row
    block, theta0 = BLOCKS[int(number)], math.radians(RELEASE_DEG[int(number)])
    time = np.linspace(0, 8, 8001)
    for model, (epsilon, pull) in (("hunt_crossley", cells[:2]), ("winkler", cells[2:])):
        parameters = TABLE2[model, foundation]
        both = [
            simulate_theta(model, block, parameters, time, theta0=theta0, rules=Rules(rule))[0]
            for rule in ("tensionless", "geometric")
        ]
        digits = len(epsilon.partition(".")[2])
        assert 100 * epsilon_theta(time, *both) == pytest.approx(float(epsilon), abs=0.6 * 10**-digits)
        assert 100 * pulled_share(model, block, parameters, theta0) == pytest.approx(float(pull), abs=0.15)


def test_table_of_the_stiff_limit(drawing):
    table = numbers("| configuration | first impact, Housner [s]")
    assert len(table) == 3
    for number, corner, guided, percent, *pivoting in table:
        block, theta0 = BLOCKS[int(number)], math.radians(RELEASE_DEG[int(number)])
        found = housner_swings(block, 1.0, theta0, until=0.1).impact_time[0]
        limit = drawing.rigid_limit(block, theta0)
        assert (corner, guided) == pytest.approx((found, limit), abs=6e-7)
        assert percent == pytest.approx(100 * (limit / found - 1), abs=6e-3)
        for k, impact in zip((1e10, 1e12), pivoting, strict=True):
            law, time = {"k": k, "lambda": 20 * k}, [0.0, 0.5]
            motion = simulate("hunt_crossley", block, law, time, theta0=theta0, rules=PIVOTING)
            assert motion.impacts[0] == pytest.approx(impact, abs=6e-7)
    stated = re.findall(r"([\d.]+) % \(configuration (\d)\)", DOCUMENT)
    assert len(stated) == 2
    for percent, number in stated:
        block, theta0 = BLOCKS[int(number)], math.radians(RELEASE_DEG[int(number)])
        corner = block.inertia_cm / block.mass_kg + block.R**2
        assert 100 * (1 - drawing.guided_inertia(block)(theta0) / corner) == pytest.approx(
            float(percent), abs=0.6
        )


@pytest.mark.parametrize(
    "row", numbers("| configuration | k found / k"), ids=lambda row: f"config{row[0]:.0f}"
)
def test_table_of_the_guided_fit(row):
    number, k_share, lambda_share, epsilon = row
    block, theta0, time = BLOCKS[int(number)], math.radians(RELEASE_DEG[int(number)]), np.arange(0, 2, 1e-3)
    true = TABLE2["hunt_crossley", "marble"]
    theta = simulate("hunt_crossley", block, true, time, theta0=theta0, rules=PIVOTING).theta
    moving = slice(0, 1 + np.flatnonzero(np.abs(theta) > 1e-4)[-1])
    fit = fit_run(
        "hunt_crossley", block, Motion(time[moving], theta[moving], 1e-4, theta0), FitSettings(free=())
    )
    assert fit.success
    assert fit.value == pytest.approx([k_share * true["k"], lambda_share * true["lambda"]], rel=0.02)
    assert 100 * fit.epsilon_theta == pytest.approx(epsilon, abs=0.005)


def face_of_a_sunken_block(block, theta, depth, height):
    """x where a horizontal beam meets the left face of a rectangle turned about its lower, sunken corner."""
    b, corner = block.b, math.copysign(block.b, theta)
    turn = np.array([[math.cos(theta), math.sin(theta)], [-math.sin(theta), math.cos(theta)]])
    foot, head = (turn @ [-b - corner, y] + [corner, -depth] for y in (0.0, block.height_m))
    return foot[0] + (head[0] - foot[0]) * (height - foot[1]) / (head[1] - foot[1])


@pytest.mark.parametrize(
    "row", numbers("| configuration | read too large at release"), ids=lambda row: f"config{row[0]:.0f}"
)
def test_table_of_the_sunken_corner(row):
    number, too_large, k_share, lambda_share, epsilon = row
    block, laser, time = BLOCKS[int(number)], LASERS[f"config{number:.0f}"], np.arange(0, 2, 1e-3)
    true = TABLE2["hunt_crossley", "marble"]
    theta0 = math.radians(RELEASE_DEG[int(number)])
    motion = simulate("hunt_crossley", block, true, time, theta0=theta0, rules=PIVOTING)
    theta, depth = motion.theta, motion.z_cb + block.b * np.sin(np.abs(motion.theta))
    y, t = laser.position + depth, np.abs(theta)
    s = np.where(theta > 0, y * np.tan(t) - 2 * block.b * (1 / np.cos(t) - 1), -y * np.tan(t))
    for i in (0, 400, 1000):
        seen = face_of_a_sunken_block(block, theta[i], depth[i], laser.position) + block.b
        assert s[i] == pytest.approx(seen, abs=1e-12)
    read = rotation_from_displacement(s, block, laser)
    assert math.degrees(read[0] - theta0) == pytest.approx(too_large, abs=6e-4)
    above = [face_of_a_sunken_block(block, theta0, depth[0], laser.position + gap) for gap in (0.0, 0.03)]
    assert math.atan((above[1] - above[0]) / 0.03) == pytest.approx(theta0, abs=1e-12)
    moving = slice(0, 1 + np.flatnonzero(t > 1e-4)[-1])
    fit = fit_run("hunt_crossley_pivoting", block, Motion(time[moving], read[moving], 1e-4, float(read[0])))
    assert fit.value[:2] == pytest.approx([k_share * true["k"], lambda_share * true["lambda"]], rel=0.02)
    assert 100 * fit.epsilon_theta == pytest.approx(epsilon, rel=0.25)


def test_depth_and_lever_at_release():
    block, s = BLOCKS[2], math.sin(math.radians(10))
    for foundation, edge, lost, uplift in (
        ("marble", "1.70 mm", "3.26 mm", "0.195°"),
        ("Aerstop", "2.64 mm", "5.06 mm", "0.468°"),
    ):
        k = TABLE2["hunt_crossley", foundation]["k"]
        depth = static_depth(block, Foundation(k), math.radians(10)) + block.b * s
        assert f"{1e3 * depth:.2f} mm" == edge
        assert f"{1e3 * depth / (3 * s):.2f} mm" == lost
        assert f"{math.degrees(math.asin(static_depth(block, Foundation(k), 0) / block.b)):.3f}°" == uplift
        assert all(text in DOCUMENT for text in (edge, lost, uplift))


def test_table_of_impact_times():
    header, *lines = (
        line.strip("|").split("|") for line in DOCUMENT[DOCUMENT.index("| impact | 1 |") :].splitlines()[:5]
    )
    which = [int(cell) - 1 for cell in header[1:]]
    block, theta0 = BLOCKS[2], math.radians(10)
    for name, *cells in lines[1:]:
        if "Housner" in name:
            times = housner_swings(block, float(name.rpartition("=")[2]), theta0, until=4.0).impact_time
        else:
            parameters = TABLE2["hunt_crossley", "marble"]
            times = simulate("hunt_crossley", block, parameters, np.array([0.0, 4.0]), theta0=theta0).impacts
        assert [float(cell) for cell in cells] == pytest.approx(times[which], abs=6e-5)


def test_fitted_restitution_is_above_that_of_every_impact():
    block, theta0, time = BLOCKS[2], math.radians(10), np.arange(0, 8, 5e-4)
    theta, _ = simulate_theta("hunt_crossley", block, TABLE2["hunt_crossley", "marble"], time, theta0=theta0)
    impacts = find_impacts(time, theta, 0.0, block, theta0=theta0).restitution[:8]
    low, high = re.search(r"r of its impacts is\s+([\d.]+)\s+to\s+([\d.]+)\.", DOCUMENT).groups()
    assert f"{impacts.min():.3f}" == low and f"{impacts.max():.3f}" == high
    fit = fit_run("housner", block, Motion(time, theta, 1e-4, theta0), FitSettings(free=()))
    assert f"has r = {fit.value[0]:.3f}." in " ".join(DOCUMENT.split())


def test_table_of_steps():
    stiffness = [float(cell) for cell in DOCUMENT[DOCUMENT.index("| k [N/m²], 5 s") :].split("|")[2:6]]
    for name, *steps in rows("| k [N/m²], 5 s"):
        model, ratio = ("winkler", "c") if "Winkler" in name else ("hunt_crossley", "lambda")
        per_k = TABLE2[model, "marble"][ratio] / TABLE2[model, "marble"]["k"]
        for k, stated in zip(stiffness, steps, strict=True):
            parameters = {"k": k, ratio: per_k * k}
            found = simulate(model, BLOCKS[2], parameters, np.array([0.0, 5.0]), theta0=math.radians(10))
            assert found.statistics["steps"] == pytest.approx(float(stated), rel=0.15)
