"""Does a law identified on some runs hold for others? Predictions, and whether blocks share a foundation."""

import math
from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter

import numpy as np
import pandas as pd
from scipy import stats

from freerock.identification.choice import epsilon_theta
from freerock.models.laws import MODELS
from freerock.models.simulate import simulate_fitted
from freerock.products.groups import fits_of
from freerock.tables.tidy import IDENTITY

PREDICTIONS = [*IDENTITY, "model", "basis", "n_runs", "epsilon_theta"]
FOUNDATIONS = ["campaign", "foundation", "model", "parameter", "n_blocks", "n_runs"]
FOUNDATIONS += ["between_blocks_percent", "between_runs_percent"]
FOUNDATIONS += ["likelihood_ratio", "likelihood_ratio_p", "f_ratio", "f_p", "shared"]
SIGNIFICANT = 0.01


def _estimates(fits) -> Iterator[dict]:
    """Successful fits of single runs.

    With a restitution per impact there is nothing to carry over.
    """
    for tree in fits:
        for run, model, fit in fits_of(tree):
            if run == "pooled" or not fit["success"].item():
                continue
            names = list(fit["parameter"].values.astype(str))
            value = dict(zip(names, fit["value"].values, strict=True))
            n = len(MODELS[model])
            if "r_2" in value:
                continue
            yield {
                **{key: str(tree.attrs[key]) for key in IDENTITY if key != "run"},
                "run": run,
                "model": model,
                "parameters": {name: value[name] for name in MODELS[model]},
                "covariance": fit["covariance"].values[:n, :n],
                "release": {name: value[name] for name in ("theta0", "t0", "width") if name in value},
            }


def _geometric_means(estimates) -> dict:
    logs = [[math.log(value) for value in each["parameters"].values()] for each in estimates]
    return dict(zip(estimates[0]["parameters"], np.exp(np.mean(logs, axis=0)).tolist(), strict=True))


def predictions(fits, motions, blocks, debonding: str = "geometric") -> pd.DataFrame:
    """How well the parameters of other runs predict a run.

    The prediction takes the run's own angle and instant of release, and width where it was freed, and the
    geometric means of the others' parameters.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets; samples are not needed.
    motions : callable
        Takes a test and returns its runs' motions, as `motion.motions_in` does; called once per test.
    blocks : mapping of str to freerock.models.block.Block
        The campaign's blocks by name.
    debonding : str
        "geometric" or "tensionless".

    Returns
    -------
    pandas.DataFrame
        Columns `PREDICTIONS`: basis is "other runs" (of the same record) or the name of another block on the
        same foundation, n_runs their number, epsilon_theta a fraction.
    """
    tests, blocks_on, rows = {}, {}, []
    estimates = list(_estimates(fits))
    for estimate in estimates:
        scene = estimate["model"], estimate["foundation"]
        tests.setdefault((*scene, estimate["test"]), []).append(estimate)
        blocks_on.setdefault(scene, {}).setdefault(estimate["block"], []).append(estimate)
    means = {
        scene: {block: (_geometric_means(own), len(own)) for block, own in every.items()}
        for scene, every in blocks_on.items()
    }
    for test, every in groupby(estimates, itemgetter("test")):
        measured = motions(test)
        for own in every:
            scene = own["model"], own["foundation"]
            others = [each for each in tests[*scene, test] if each["run"] != own["run"]]
            bases = {"other runs": (_geometric_means(others), len(others))} if others else {}
            bases |= {block: mean for block, mean in means[scene].items() if block != own["block"]}
            motion = measured[own["run"]]
            release = {"theta0": motion.theta0} | own["release"]
            for basis, (parameters, n_runs) in bases.items():
                theta = simulate_fitted(
                    own["model"],
                    blocks[own["block"]],
                    release | parameters,
                    motion.time_s,
                    debonding=debonding,
                )
                rows.append(
                    {
                        **{key: own[key] for key in (*IDENTITY, "model")},
                        "basis": basis,
                        "n_runs": n_runs,
                        "epsilon_theta": epsilon_theta(motion.time_s, theta, motion.theta),
                    }
                )
    return pd.DataFrame(rows, columns=PREDICTIONS)


def shared_foundation(fits) -> pd.DataFrame:
    """Do the blocks on one foundation have the same k and damping?

    Two answers. The likelihood ratio of one set of parameters per block against one for all, in the
    quadratic approximation of the likelihood around each run's estimate: it takes the standard errors
    at their word. The F ratio of the scatter between the blocks' means to that between the runs of a block:
    it allows for what differs from one release to the next. Parameters are compared as logarithms.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets of a campaign.

    Returns
    -------
    pandas.DataFrame
        Columns `FOUNDATIONS`, one row per foundation with two blocks or more, model and parameter; the
        likelihood ratio is that of all parameters of the model together. shared tells whether the F test
        leaves it standing (p ≥ 0.01).
    """
    frame = pd.DataFrame(_estimates(fits))
    rows = []
    if frame.empty:
        return pd.DataFrame(rows, columns=FOUNDATIONS)
    frame = frame[frame["model"] != "housner"]  # its r belongs to the block
    for (campaign, foundation, model), group in frame.groupby(
        ["campaign", "foundation", "model"], sort=False
    ):
        logs = {
            block: np.log([list(p.values()) for p in own["parameters"]])
            for block, own in group.groupby("block", sort=False)
        }
        if len(logs) < 2:
            continue
        ratio, ratio_p = _likelihood_ratio(group)
        n_runs, n_blocks = len(group), len(logs)
        within = sum(((v - v.mean(axis=0)) ** 2).sum(axis=0) for v in logs.values())
        every = np.concatenate(list(logs.values()))
        between = sum(len(v) * (v.mean(axis=0) - every.mean(axis=0)) ** 2 for v in logs.values())
        for i, name in enumerate(MODELS[model]):
            f_ratio = f_p = scatter = math.nan
            if n_runs > n_blocks:
                scatter = math.sqrt(within[i] / (n_runs - n_blocks))
                f_ratio = between[i] / (n_blocks - 1) / scatter**2
                f_p = float(stats.f.sf(f_ratio, n_blocks - 1, n_runs - n_blocks))
            means = [v.mean(axis=0)[i] for v in logs.values()]
            rows.append(
                {
                    "campaign": campaign,
                    "foundation": foundation,
                    "model": model,
                    "parameter": name,
                    "n_blocks": n_blocks,
                    "n_runs": n_runs,
                    "between_blocks_percent": 100 * np.std(means, ddof=1),
                    "between_runs_percent": 100 * scatter,
                    "likelihood_ratio": ratio,
                    "likelihood_ratio_p": ratio_p,
                    "f_ratio": f_ratio,
                    "f_p": f_p,
                    "shared": bool(f_p >= SIGNIFICANT)
                    if math.isfinite(f_p)
                    else bool(ratio_p >= SIGNIFICANT),
                }
            )
    return pd.DataFrame(rows, columns=FOUNDATIONS)


def _likelihood_ratio(group) -> tuple:
    """-2 ln of the ratio of one mean for all blocks to one per block, and its p-value."""

    def misfit(rows):
        logs = np.log([list(p.values()) for p in rows["parameters"]])
        weights = np.array(
            [
                np.linalg.inv(covariance / np.outer(value, value))
                for covariance, value in zip(rows["covariance"], np.exp(logs), strict=True)
            ]
        )
        mean = np.linalg.solve(weights.sum(axis=0), np.einsum("nij,nj->i", weights, logs))
        return float(np.einsum("ni,nij,nj->", logs - mean, weights, logs - mean)), len(mean)

    every, n_parameters = misfit(group)
    blocks = [misfit(own)[0] for _, own in group.groupby("block", sort=False)]
    ratio = every - sum(blocks)
    return ratio, float(stats.chi2.sf(ratio, n_parameters * (len(blocks) - 1)))
