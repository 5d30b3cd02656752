"""Record and fit datasets of made-up numbers, written and read by the pipeline's own functions."""

import functools
import tempfile
from pathlib import Path

import lmfit
import numpy as np
import xarray as xr

from freerock.errors import FreerockError
from freerock.identification.fitted import Curve, Evidence, Fit, ImpactScatter
from freerock.identification.paper_fit import PaperFit
from freerock.identification.scatter import Scatter
from freerock.identification.u_total import Uncertainty
from freerock.models.given import legal
from freerock.models.laws import CANDIDATES, MODELS, PAPER_MODELS
from freerock.noise.spectrum import white_noise
from freerock.products import netcdf as datasets
from freerock.products.runs import runs_in
from freerock.runs.impacts import Impacts
from freerock.runs.runs import Measured, Run
from freerock.runs.u_of_measured import Contributions, MeasuredTotal
from freerock.runs.verdict import Reason, Verdict
from freerock.selection.choice import Choice, Judged
from freerock.tables.campaign_tables import joined, rows_of

VALUES = {"r": 0.957, "width": 0.066, "k": 6.88e6, "c": 2.36e4, "lambda": 1.30e8}
STDERR = {"r": 0.0012, "width": 1e-4, "k": 1.2e4, "c": 310.0, "lambda": 4.0e5}
SIGMA = np.radians(0.01)
RATE_HZ = 200.0
RANK = {law: i for i, law in enumerate(PAPER_MODELS)}
EPSILON, OVER = (0.246, 0.026, 1.3e-6), (9e4, 2e3, 1.1)  # ε_θ, and the residual over the noise, of each law
LEFT_OUT = Reason("warn", "excluded", "excluded: the block slid & turned <1°")


def swing(time_s, theta0_deg, frequency_hz=1.2):
    """A decaying swing [rad], held before time 0."""
    time_s = np.maximum(time_s, 0.0)
    return np.radians(theta0_deg) * np.exp(-time_s / 1.5) * np.cos(2 * np.pi * frequency_hz * time_s)


def impacts(release_s, theta0_deg, decay=0.8, error=0.002):
    n = np.arange(4)
    peaks, small = np.radians(theta0_deg) * decay**n, np.full(4, 1e-4)
    r, r_stderr = 0.94 + 0.003 * n, np.full(4, error)
    return Impacts(release_s + 0.3 + 0.4 * n, small, peaks, small, -peaks * decay, small, r, r_stderr, 0.0)


def identity(test, block, foundation, origin):
    return {"campaign": "made_up", "test": test, "block": block, "foundation": foundation, "origin": origin}


def record(test="b1_marble", block="b1", foundation="marble", origin="simulated", n_runs=3, theta0_deg=10.0):
    """A record with a run every 6 s; of three runs the last is excluded."""
    time_s = np.arange(round(RATE_HZ * (6 * n_runs + 1))) / RATE_HZ
    theta, runs, found = np.zeros_like(time_s), [], []
    for number in range(1, n_runs + 1):
        release, angle = 6.0 * number - 4.0, theta0_deg + 0.1 * number
        during = (time_s > release - 1) & (time_s < release + 4)
        theta[during] = swing(time_s[during] - release, angle)
        excluded = n_runs == number == 3
        runs.append(
            Run(
                number=number,
                hold_start_s=release - 1,
                release_s=release,
                release_stderr_s=0.002,
                fit_start_s=release + 0.02,
                end_s=release + 4,
                theta0=np.radians(angle),
                theta0_stderr=1e-4,
                sigma_theta=SIGMA,
                n_impacts=4,
                verdict=Verdict((LEFT_OUT,) if excluded else ()),
            )
        )
        found.append(impacts(release, angle))
    theta += np.random.default_rng(1).normal(0, SIGMA, len(time_s))
    flags = np.zeros(len(time_s), np.uint8)
    flags[100:105] = 1
    volts = xr.Dataset(
        {
            "theta": ("time", np.where(flags, np.nan, theta)),
            "sigma_theta": ("time", np.full(len(time_s), SIGMA)),
            "flags": ("time", flags),
            "voltage": ("time", np.where(flags, 10.2, 5 + 10 * theta)),
            "fault_start": ("fault", [time_s[100], 0.0]),
            "fault_end": ("fault", [time_s[104], time_s[-1]]),
            "fault_note": ("fault", ["5 samples", "50.00 Hz, 0.001 V, removed"]),
            "fault_angle": ("fault", [np.nan, 5e-5]),
        },
        coords={"time": time_s, "fault": ["error_level", "mains_interference"]},
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "record.nc")
        who, n = identity(test, block, foundation, origin), len(found[0].time_s)
        total = MeasuredTotal(np.radians(0.02), np.full(n, 2e-4), np.full(n, 2e-4), np.full(n, 0.003))
        totals, noise = [total] * len(runs), white_noise(SIGMA, RATE_HZ)
        datasets.write_record(path, volts, Measured(runs, found, noise), totals, who)
        return datasets.open_record(path)


def failed_record():
    error = FreerockError("b1_broken.tdms", "the file is truncated", "record it again")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "record.nc")
        reason = Reason("fail", "not_processed", str(error))
        datasets.write_failure(path, reason, identity("b1_broken", "b1", "marble", "simulated"))
        return datasets.open_record(path)


def fits(tree, failed=(), models=PAPER_MODELS):
    """Fits of the runs of a record that are not excluded, by each candidate and by the paper's procedure."""
    runs = [run for run in runs_in(tree) if not run.excluded]
    fitted = {run.number: {model: fit(tree, model, run, failed) for model in models} for run in runs}
    papers = {
        run.number: {law: paper_fit(tree, law, run, failed) for law in models if law in PAPER_MODELS}
        for run in runs
    }
    attrs = {key: tree.attrs[key] for key in (*identity(*"    "), "verdict", "reasons")}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "fits.nc")
        datasets.write_fits(path, fitted, attrs, choice(models, failed), papers)
        return datasets.open_fits(path)


def choice(models, failed=()):
    """Of candidates the last is selected that did not fail."""
    good = [model for model in models if model not in failed]
    if not good:
        each = tuple(Judged(model, "not_fitted", "no fit is to be used") for model in models)
        return Choice("", "none", "none", "no fit is to be used", each)
    each = []
    for model in models:
        if model in failed:
            each.append(Judged(model, "not_fitted", "k lies at its bound"))
            continue
        status = "selected" if model == good[-1] else "rejected"
        why = "the evidence is for it" if status == "selected" else "the evidence is against it"
        rank = RANK[CANDIDATES[model].law]
        each.append(Judged(model, status, why, OVER[-1 - rank] ** 2, len(MODELS[model]), OVER[rank]))
    reason = "it leaves no more than the noise, with the greatest evidence"
    return Choice(good[-1], "noise", "evidence", reason, tuple(each))


def named(model):
    """Parameters of a candidate."""
    freed = ["width"] if CANDIDATES[model].width else []
    return (*MODELS[model], *freed, *(["theta0"] if model != "housner" else []))


def curve(tree, law, run):
    """Measured rotation and that of a law since the release."""
    time_s = tree["time"].values
    span = (time_s >= run.release_s) & (time_s <= run.end_s)
    since = time_s[span] - run.release_s
    own = swing(since, np.degrees(run.theta0), 1.24 - 0.02 * RANK[law])
    return Curve(since, tree["theta"].values[span], own)


def least_squares(names):
    """What lmfit says of parameters."""
    params = lmfit.Parameters()
    for name in names:
        params.add(legal(name), value=VALUES.get(name, 0.17))
    return lmfit.minimizer.MinimizerResult(params=params, method="least_squares", nfev=20)


def held(inputs, values):
    """Contributions of inputs that a fit holds."""
    n = len(inputs)
    return Contributions(inputs, values, np.zeros(n), np.ones(n), np.full(n, np.nan), np.array(values))


def fit(tree, model, run, failed):
    law, names = CANDIDATES[model].law, named(model)
    rank, n = RANK[law], len(names)
    stderr = np.array([STDERR.get(name, 1e-5) for name in names])
    contributions = held((), np.zeros((n, 0)))
    delta = 0.005 * np.array([1.0, -1.0, 0.5, -0.5])
    return Fit(
        model=model,
        values={name: VALUES.get(name, np.radians(10)) for name in names},
        uncertainty=Uncertainty(np.diag(5 * stderr**2), stderr, 2 * stderr, contributions),
        curve=curve(tree, law, run),
        evidence=Evidence(
            epsilon_theta=EPSILON[rank],
            agrees=rank == 2,
            noise_p=[0.0, 1e-9, 0.5][rank],
            residual_over_noise=OVER[rank],
            noise_low_hz=1.0,
            noise_high_hz=2.0,
            minus_two_log=-10.0 * rank,
            n_parameters=n,
            evaluations=20,
        ),
        scatter=ImpactScatter(
            Scatter(0.006, 0.004, 0.01, 9.0), delta, 0 * delta + 1e-3, np.eye(4), np.zeros((n, 4))
        ),
        success=model not in failed,
        message="k lies at its bound" if model in failed else "converged",
        result=least_squares(names),
        impacts=impacts(0.0, np.degrees(run.theta0), 0.8 + 0.02 * rank, 0.0),
    )


def paper_fit(tree, law, run, failed):
    names = named(law)
    return PaperFit(
        model=law,
        values={name: VALUES.get(name, np.radians(10)) for name in names},
        stderr=np.array([STDERR.get(name, 1e-5) for name in names]),
        epsilon_theta=EPSILON[RANK[law]],
        curve=curve(tree, law, run),
        success=law not in failed,
        message="converged",
        result=least_squares(names),
        impacts=impacts(0.0, np.degrees(run.theta0), 0.8 + 0.02 * RANK[law], 0.0),
    )


@functools.cache
def campaign():
    """Records and fits of two blocks on two foundations, and a record that failed."""
    records = [
        record("b1_marble"),
        record("b1_mat", "b1", "mat"),
        record("b2_marble", "b2", "marble", n_runs=2, theta0_deg=-20.0),
        record("b2_mat", "b2", "mat", n_runs=1, theta0_deg=-20.0),
        failed_record(),
    ]
    return records, [fits(tree) for tree in records]


def tidy_tables(records, fitted):
    """The tidy tables of records and their fits, by name."""
    return joined([rows_of(records, fitted)])
