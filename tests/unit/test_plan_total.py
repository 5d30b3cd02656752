"""Total uncertainty before any test: against refits, draws of whole campaigns and the closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest
from planned import campaign

from freerock.config.keys_of_plan import SensorSection
from freerock.config.mistakes import ConfigError
from freerock.identification.fit import fit_run
from freerock.models.laws import LAWS
from freerock.models.simulate import Solver, simulate_theta
from freerock.planning.plan import COLUMNS, Choices, Setup, plan
from freerock.planning.plan_campaign import plan_campaign
from freerock.planning.plan_total import (
    ALL,
    BUDGET,
    NOISE,
    TOTALS,
    plan_budget,
    plan_known,
    plan_totals,
)
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.runs.motion import Motion
from freerock.runs.noise_spectrum import white_noise
from freerock.virtual_lab.palermo import CONFIGURATIONS

BLOCKS = {name: CONFIGURATIONS[name][0] for name in ("config1", "config2")}
SOIL = {"k": 2.86e6, "lambda": 8.16e7}
LASER = Laser("horizontal", 0.2, 0.1)


def laboratory(name, **u):
    known = {"width_m": (name, 3e-4), "height_m": (name, 3e-4), "position_m": ("laser", 6e-4)}
    known |= {"scale_fraction": ("laser", 1e-3)}
    inputs = [Input(owner, key, u.get(key, each), True) for key, (owner, each) in known.items()]
    return Laboratory(BLOCKS[name], {"laser": LASER}, tuple(inputs))


def setup(name, expected, angle=6.0, **u):
    return Setup((name, "mat", "laser"), laboratory(name, **u), expected, [angle])


CHOICES = Choices({"s": SensorSection(noise_v=0.002)}, durations_s=(2.0,))


@pytest.mark.parametrize(
    ("model", "values"), [("hunt_crossley", SOIL), ("housner", {"r": 0.9}), ("winkler", {"k": 4e6, "c": 2e4})]
)
def test_contributions_are_those_of_a_fit_of_such_a_run(model, values):
    """Without a beam, so that the rotation is what is measured: a fit of an independent simulation."""
    block, time_s, sigma = BLOCKS["config2"], np.arange(0.03, 2.0, 1 / 2000), 1e-5
    theta, _ = simulate_theta(model, block, values, time_s, theta0=0.1, solver=Solver(1e-10))
    theta = theta + sigma * np.random.default_rng(1).standard_normal(theta.size)
    inputs = [Input("b", name, 3e-4, True) for name in ("width_m", "height_m")]
    inputs += [Input("l", "scale_fraction", 1e-3, True), Input("l", "sampling_rate_fraction", 6e-5, True)]
    laser = Laser(units="rad")
    lab = Laboratory(block, {"l": laser}, tuple(inputs))
    motion = Motion(time_s, theta, sigma, 0.1, 1e-5, 1e-4, noise=white_noise(sigma, 2000.0), laboratory=lab)
    fit = fit_run(model, block, motion)
    assert fit.success and np.abs(fit.contributions.moved).max() < 3
    one = Setup(("b", "f", "l"), lab, {model: values}, [math.degrees(0.1)])
    sensor = SensorSection(noise_deg=math.degrees(sigma))
    budget = plan_budget(plan_known([one], replace(CHOICES, sensors={"s": sensor})))
    assert list(budget.columns) == BUDGET
    for name, rows in budget.groupby("parameter", sort=False):
        i = fit.parameters.index(name)
        *planned, noise = rows["contribution_fraction"]
        known = fit.contributions.values[i] / values[name]
        if LAWS[model].is_foundation:
            assert planned == pytest.approx(known, rel=0.1, abs=0.1 * np.abs(known).max())
        else:  # a rigid block's run tells its inputs
            assert max(np.abs(planned).max(), np.abs(known).max()) < noise / 10
        assert rows["input"].iloc[-1] == NOISE and noise == pytest.approx(
            fit.stderr[i] / values[name], rel=0.1
        )


def table(setups, n_runs=(1, 3, 12), spread=0.03):
    errors, known = plan(setups, CHOICES), plan_known(setups, CHOICES)
    return errors, plan_budget(known), plan_totals(errors, known, n_runs, {"mat": {"k": spread}})


def test_the_two_parts_of_u_and_what_no_number_of_runs_makes_smaller():
    errors, budget, totals = table([setup("config2", {"hunt_crossley": SOIL})])
    assert list(errors.columns) == COLUMNS and list(totals.columns) == TOTALS
    k = totals[totals["parameter"] == "k"].set_index("n_runs")
    of_k = budget[budget["parameter"] == "k"].set_index("input")["contribution_fraction"]
    noise, shifts = of_k[NOISE], of_k.drop(NOISE)
    assert noise > errors.set_index("parameter").loc["k", "stderr"] / SOIL["k"]  # of exact inputs
    floor = math.sqrt(sum(shifts**2))
    for n in (1, 3, 12):
        runs = math.sqrt((0.03**2 + noise**2) / n)
        assert k.loc[n, "runs_fraction"] == pytest.approx(runs)
        assert k.loc[n, "inputs_fraction"] == pytest.approx(floor)
        assert k.loc[n, "u_total"] == pytest.approx(SOIL["k"] * math.hypot(runs, floor))
    assert math.isnan(k.loc[1, "half95"])
    exact = {}
    for name in shifts.index:
        others = table([setup("config2", {"hunt_crossley": SOIL}, **{name: 0.0})])[2]
        exact[name] = others[others["parameter"] == "k"].set_index("n_runs")["u_total"][3]
    first = min(exact, key=exact.get)
    assert k.loc[3, "first_input"] == first and k.loc[3, "first_owner"] in ("config2", "laser")
    assert k.loc[3, "u_total_without_first"] == pytest.approx(exact[first], rel=1e-3)
    assert k.loc[3, "first_share"] == pytest.approx(1 - (exact[first] / k.loc[3, "u_total"]) ** 2, rel=0.01)


def test_draws_of_campaigns_scatter_as_planned():
    """Runs drawn with their spread, inputs with their errors, over two blocks that share a laser."""
    setups = [setup(name, {"hunt_crossley": SOIL}) for name in BLOCKS]
    _, budget, totals = table(setups)
    draw, n, many = np.random.default_rng(3), 3, 40_000
    of_k = budget[budget["parameter"] == "k"]
    owners = sorted(set(zip(of_k["input_owner"], of_k["input"], strict=True)) - {("", NOISE)})
    off = {owner: draw.standard_normal(many) for owner in owners}
    means = {}
    for name in BLOCKS:
        own = of_k[of_k["block"] == name]
        noise = own[own["input"] == NOISE]["contribution_fraction"].item()
        runs, own = math.hypot(0.03, noise) * draw.standard_normal((n, many)), own[own["input"] != NOISE]
        shift = sum(row.contribution_fraction * off[row.input_owner, row.input] for row in own.itertuples())
        means[name] = runs.mean(axis=0) + shift
        spread = runs.std(axis=0, ddof=1) / math.sqrt(n)
        planned = row_of(totals, name, n)
        assert means[name].std() * SOIL["k"] == pytest.approx(planned["u_total"], rel=0.02)
        assert spread.mean() == pytest.approx(planned["runs_fraction"], rel=0.15)  # its mean is below it
    both = sum(means.values()) / 2
    assert both.std() * SOIL["k"] == pytest.approx(row_of(totals, ALL, n)["u_total"], rel=0.02)
    alone = [row_of(totals, name, n)["inputs_fraction"] for name in BLOCKS]
    assert row_of(totals, ALL, n)["inputs_fraction"] > math.hypot(*alone) / 2  # the laser is the same


def row_of(totals, block, n):
    rows = totals[(totals["block"] == block) & (totals["parameter"] == "k") & (totals["n_runs"] == n)]
    return rows.iloc[0]


def test_a_campaign_plans_its_total_from_its_own_inputs(tmp_path):
    def change(keys):
        keys["plan"]["n_runs"] = [1, 3]
        keys["blocks"]["config2"]["uncertainty"] = {"width_m": 0.0}

    found = plan_campaign(campaign(tmp_path, change))
    owners = set(zip(found.budget["input_owner"], found.budget["input"], strict=True))
    assert {("config1", "width_m"), ("at_200mm", "position_m")} <= owners
    exact = found.budget[(found.budget["input_owner"] == "config2") & (found.budget["input"] == "width_m")]
    followed = exact["sensor"] != "range_50mm"  # whose range config2 leaves
    assert (exact["contribution_fraction"][followed] == 0).all() and exact["input_stated"].all()
    assert exact["contribution_fraction"][~followed].isna().all() and 0 < followed.sum() < len(exact)
    k = found.totals[(found.totals["model"] == "hunt_crossley") & (found.totals["parameter"] == "k")]
    assert set(k["block"]) == {"config1", "config2", "config3", ALL} and set(k["n_runs"]) == {1, 3}
    assert np.isfinite(k["u_total"]).all()
    assert set(found.totals["model"]) == {"housner", "winkler", "hunt_crossley"}


MISTAKES = {
    "unknown foundation": (
        lambda plan: plan.update(spread_fraction={"marbel": {"k": 0.03}}),
        "plan: 'marbel' is not a foundation of this campaign; did you mean 'marble'?",
    ),
    "unknown parameter": (
        lambda plan: plan.update(spread_fraction={"marble": {"kk": 0.03}}),
        "plan.spread_fraction: 'kk' is not a parameter of a law; did you mean 'k'?",
    ),
    "no run": (
        lambda plan: plan.update(n_runs=[0]),
        "plan.n_runs.0: 0 is not greater than 0; give the numbers of runs of each block, one or more",
    ),
    "none": (
        lambda plan: plan.update(n_runs=[]),
        "plan.n_runs: is empty; give the numbers of runs of each block, one or more",
    ),
}


@pytest.mark.parametrize(("change", "line"), MISTAKES.values(), ids=MISTAKES)
def test_mistakes_are_told_in_one_line(change, line, tmp_path):
    with pytest.raises(ConfigError) as caught:
        campaign(tmp_path, lambda keys: change(keys["plan"]))
    (message,) = str(caught.value).splitlines()
    assert message.partition(": ")[2] == line
