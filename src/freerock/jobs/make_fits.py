"""The models identified on the runs of one record."""

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import lmfit

from freerock.config.processing import ImpactLimits
from freerock.identification.fitted import Fit
from freerock.identification.paper_fit import PaperFit
from freerock.models.block import Block
from freerock.models.laws import MODELS
from freerock.populations.impact_energy import energies_of_record
from freerock.products.contents import NotFitted
from freerock.products.netcdf import open_record, write_fits
from freerock.products.provenance import provenance
from freerock.products.runs import OVER_TIME, motions_in, runs_in
from freerock.rotation.laboratory import Laboratory
from freerock.runs.impacts import find_impacts
from freerock.runs.motion import Motion
from freerock.runs.verdict import Reason
from freerock.selection.candidates import Allowed
from freerock.selection.choice import Choice
from freerock.selection.identify import Identified, identify_record
from freerock.selection.reasons import reasons_of_fit

Fitted = TypeVar("Fitted", Fit, PaperFit)
log = logging.getLogger("freerock")


def give_up_fits(settings: Mapping[str, Any], output: str | Path, reason: str) -> None:
    """Write the fits of a record in whose identification something unforeseen happened: none."""
    outcome = {"verdict": "fail", "reasons": [Reason.of("not_processed", reason)]}
    write_fits(output, {}, settings["attributes"] | outcome | {"not_fitted": [NotFitted(None, reason)]})


def make_fits(
    settings: Mapping[str, Any],
    record_file: str | Path,
    output: str | Path,
    identify: Callable[[Block, Mapping[int, Motion], Allowed], Identified] = identify_record,
) -> None:
    """Write the fits of a record.

    Parameters
    ----------
    settings : mapping
        block, laboratory, attributes, models, kinematics (of the rivals), free (by law), options (of
        `FitSettings`), impacts: sections of the configuration as plain values.
    record_file : path
        Dataset of the record.
    output : path
        netCDF file to write; without groups where no run can be fitted.
    identify : callable
        What is identified of the runs of the record: one that remembers spares the work on runs that have not
        changed.
    """
    record = open_record(record_file, samples=False)
    usable = {run.number for run in runs_in(record) if run.verdict.level != "fail" and not run.excluded}
    seen = motions_in(record, open_record(record_file, only=OVER_TIME).dataset)
    block, laboratory = Block(**settings["block"]), Laboratory.of(settings["laboratory"])
    allowed = Allowed(*(settings[key] for key in ("models", "kinematics", "free", "options")))
    motions = {n: replace(each, laboratory=laboratory) for n, each in seen.items() if n in usable}
    found = identify(block, motions, allowed)
    choice, limits = found.choice, ImpactLimits(**settings["impacts"])
    fits: dict[int, dict[str, Fit]] = {}
    for name in MODELS:
        for number, fit in found.fits.get(name, {}).items():
            fits.setdefault(number, {})[name] = _with_impacts(fit, block, limits)
    reasons = {
        number: list(reasons_of_fit(motion, fits.get(number, {}).get(choice.selected), choice))
        for number, motion in motions.items()
    }
    _report(fits, choice, reasons)
    attributes = settings["attributes"] | {key: record.attrs[key] for key in ("verdict", "reasons")}
    attributes |= {key: each for key, each in record.attrs.items() if str(key).startswith("sensor_")}
    missed = [f"{name} not fitted: {found.missing[name]}" for name in allowed.always if name in found.missing]
    if missed:
        attributes["not_fitted"] = [NotFitted(None, each) for each in missed]
    attributes["provenance"] = provenance([record_file], settings)
    debonding = allowed.settings(allowed.candidates[0]).debonding
    energies = energies_of_record(fits, motions, block, limits, debonding)
    papers = {
        number: {law: _with_impacts(fit, block, limits) for law, fit in own.items()}
        for number, own in found.paper.items()
    }
    write_fits(output, fits, attributes, choice, papers, reasons, energies)


def _report(
    fits: Mapping[int, Mapping[str, Fit]], choice: Choice, reasons: Mapping[int, list[Reason]]
) -> None:
    """Log what was found of each run."""
    for number, own in fits.items():
        for name, fit in own.items():
            log.info("run %d, %s: ε_θ = %.4g, %s", number, name, fit.epsilon_theta, fit.message)
            log.info("%s", lmfit.fit_report(fit.result))
    log.info("%s: %s", choice.selected or "no candidate", choice.reason)
    for number, each in reasons.items():
        for reason in each:
            log.info("run %d: %s", number, reason.text)


def _with_impacts(fit: Fitted, block: Block, limits: ImpactLimits) -> Fitted:
    """The fit with the impacts of the modelled motion."""
    theta0 = fit.values.get("theta0", fit.curve.theta_model[0])
    impacts = find_impacts(fit.curve.time, fit.curve.theta_model, 0.0, block, theta0=theta0, limits=limits)
    return replace(fit, impacts=impacts)
