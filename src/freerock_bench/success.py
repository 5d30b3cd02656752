"""Does the identification find the minimum?

python -m freerock_bench.success results/studies/success.csv full
"""

import sys
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from freerock.identification.fit import fit_record, fit_run
from freerock.models.laws import LAWS, PAPER_MODELS
from freerock_bench.harness import NUMBERS, Study, rows_of_fit
from freerock_bench.virtual_run import Row, Truth, draw_truth, drawn_run

RUNS = {"full": 1000, "small": 4}  # random truths of each law
DEMANDING = {"full": 500, "small": 1}  # further ones of each law of a foundation
LEAST_TO_MOST = {"c": (1e-4, 2e-2), "lambda": (0.4, 50.0)}  # ratio to k of these [s, s/m]
RELEASES = (0.3, 0.95)  # of the critical angle
FINEST = 1e-14  # rtol of their truths
EXCESS = 1.0  # of the squared residual over σ², up to which two fits are in one minimum: a standard error


def cases(size: str) -> list[tuple[str, int, bool]]:
    """Law, number, and whether it is a demanding one."""
    plain = [(model, i, False) for model in PAPER_MODELS for i in range(RUNS[size])]
    compliant = [model for model in PAPER_MODELS if LAWS[model].is_foundation]
    return plain + [(model, i, True) for model in compliant for i in range(DEMANDING[size])]


def demanding(model: str, noises: Sequence[str], generator: np.random.Generator) -> Truth:
    """Any block, hardly damped or not, released from any angle up to 0.95 of the critical one.

    The least λ/k damps about as much as the least c/k, at the depths of an impact. Some of these motions
    multiply errors; the truth is integrated as exactly as double precision allows.
    """
    truth = draw_truth(model, noises, generator)
    (damping,) = LAWS[model].ratios
    k, ratio = truth.parameters["k"], 10 ** generator.uniform(*np.log10(LEAST_TO_MOST[damping]))
    angle = generator.uniform(*RELEASES) * truth.block.theta_cr
    return replace(truth, parameters={"k": k, damping: k * ratio}, theta0=angle, rtol=FINEST)


def rows_of(case: tuple[str, int, bool]) -> list[Row]:
    """Rows of a case.

    `excess` is that of the squared residual over a fit from the truth, of a demanding case over the truth
    itself [σ²]; `reached`: no excess; `reported`: the program itself says that the fit failed.
    """
    model, i, demands = case
    noises, key = ("white", "coloured"), (1, PAPER_MODELS.index(model), i)
    if demands:
        truth, motion = drawn_run(model, noises, (*key, 1), demanding)
    else:
        truth, motion = drawn_run(model, noises, key)
    fit = fit_run(model, truth.block, motion)
    if demands:
        best = truth.motion(motion.time_s - motion.time_s[0])[0] - motion.theta
    else:
        best = fit_record(model, truth.block, [motion], start=list(truth.parameters.values())).residual
    excess = float((np.sum(fit.residual**2) - np.sum(best**2)) / motion.sigma_theta**2)
    own = {
        "model": model,
        "run": i,
        "noise": truth.noise,
        "release": truth.theta0 / truth.block.theta_cr,
        "excess": excess,
        "reached": excess < EXCESS,
        "reported": not fit.success,
        "message": fit.message,
    }
    name = f"{model}, {'demanding' if demands else 'whole range'}"
    return [row | own for row in rows_of_fit(name, fit, dict(truth.parameters))]


COLUMNS = [*NUMBERS, "model", "run", "noise", "release", "excess", "reached", "reported", "message"]
STUDY = Study(cases, rows_of, COLUMNS)
run = STUDY.run

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
