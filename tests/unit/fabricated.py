"""Record and fit datasets of made-up numbers, written and read by the pipeline's own functions."""

import functools
import tempfile
from pathlib import Path

import numpy as np
import xarray as xr
from freerock.identification.model_discrepancy import Part

from freerock.errors import FreerockError
from freerock.identification.fit import Fit
from freerock.models.free_parameters import unit_of
from freerock.models.laws import CANDIDATES, MODELS, PAPER_MODELS
from freerock.noise.spectrum import white_noise
from freerock.products import netcdf as datasets
from freerock.products.runs import runs_in
from freerock.runs.impacts import Impacts
from freerock.runs.measured_total import MeasuredTotal
from freerock.runs.segment import Run
from freerock.runs.verdict import Reason, Verdict
from freerock.selection.choice import choose, evidence
from freerock.tables.tidy_tables import joined, rows_of

VALUES = {"r": 0.957, "width": 0.066, "k": 6.88e6, "c": 2.36e4, "lambda": 1.30e8}
STDERR = {"r": 0.0012, "width": 1e-4, "k": 1.2e4, "c": 310.0, "lambda": 4.0e5}
SIGMA = np.radians(0.01)
RATE_HZ = 200.0
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
        datasets.write_record(path, volts, runs, found, who, totals=totals, noise=noise)
        return datasets.open_record(path)


def failed_record():
    error = FreerockError("b1_broken.tdms", "the file is truncated", "record it again")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "record.nc")
        reason = Reason("fail", "not_processed", str(error))
        datasets.write_failure(path, reason, identity("b1_broken", "b1", "marble", "simulated"))
        return datasets.open_record(path)


def fits(tree, failed=(), models=PAPER_MODELS):
    """Fits of the runs of a record that are not excluded."""
    runs = [run for run in runs_in(tree) if not run.excluded]
    fitted = {run.number: {model: fit(tree, model, run, failed) for model in models} for run in runs}
    attrs = {key: tree.attrs[key] for key in (*identity(*"    "), "verdict", "reasons")}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "fits.nc")
        choices = {run: choose([evidence(each) for each in own.values()]) for run, own in fitted.items()}
        datasets.write_fits(path, fitted, attrs, choices)
        return datasets.open_fits(path)


def fit(tree, model, run, failed):
    rank = PAPER_MODELS.index(CANDIDATES[model].law)
    time_s = tree["time"].values
    span = (time_s >= run.release_s) & (time_s <= run.end_s)
    since, angle = time_s[span] - run.release_s, np.degrees(run.theta0)
    own, theta = swing(since, angle, 1.24 - 0.02 * rank), tree["theta"].values[span]
    names = (
        *MODELS[model],
        *(["width"] if CANDIDATES[model].width else []),
        *(["theta0"] if model != "housner" else []),
    )
    value = np.array([VALUES.get(name, np.radians(10)) for name in names])
    stderr = np.array([STDERR.get(name, 1e-5) for name in names])
    return Fit(
        model=model,
        parameters=names,
        value=value,
        stderr=stderr,
        ci95_low=value - 1.96 * stderr,
        ci95_high=value + 1.96 * stderr,
        discrepancy=2 * stderr,
        covariance=np.diag(stderr**2),
        units=tuple(map(unit_of, names)),
        time=since,
        theta=theta,
        theta_model=own,
        residual=own - theta,
        epsilon_theta=[0.246, 0.026, 1.3e-6][rank],
        epsilon_holdout=np.nan,
        final_time_s=4.0,
        aic=-10.0 * rank,
        bic=-8.0 * rank,
        n_parameters=len(names),
        success=model not in failed,
        message="k lies at its bound" if model in failed else "converged",
        impacts=impacts(0.0, angle, 0.8 + 0.02 * rank, 0.0),
        diagnostics={
            "evaluations": 20.0,
            "rtol": [1e-6, 1e-6, 1e-7][rank],
            "integrator_error": [0.0, 0.002, 0.004][rank],
            "averaged": 16.0,
            "white": 0.0,
            "noise": [0.0, 0.0, 1.0][rank],
            "noise_p": [0.0, 1e-9, 0.5][rank],
            "noise_ratio": [9e4, 2e3, 1.1][rank],
            "noise_low_hz": 1.0,
            "noise_high_hz": 2.0,
            "residual_over_sigma": [200.0, 60.0, 1.0][rank],
            "coloured": [1.0, 1.0, 0.0][rank],
        },
        parts=()
        if model in failed
        else tuple(
            Part(*span_s, scale * value, stderr, np.diag(stderr**2))
            for span_s, scale in (((0.0, 1.0), 1.01), ((1.0, 4.0), 1.0))
        ),
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
