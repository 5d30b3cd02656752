"""The models identified on each run of one record."""

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import lmfit

from freerock.config.processing import ImpactLimits
from freerock.identification.fit import Fit, ImpactEnergy
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, MODELS, law_of
from freerock.populations.impact_energy import impact_energy, of_measured
from freerock.populations.sensitivity import with_contributions
from freerock.products.groups import NotFitted, runs_of
from freerock.products.netcdf import open_record, samples_in, write_fits
from freerock.products.provenance import provenance
from freerock.products.runs import OVER_TIME, impacts_in, measured_in, runs_in
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.view import view_of
from freerock.runs.impacts import Impacts, find_impacts
from freerock.runs.motion import Motion
from freerock.runs.segment import Run
from freerock.runs.verdict import Reason
from freerock.selection.allowed_hypotheses import Hypotheses
from freerock.selection.choice import Choice
from freerock.selection.hypotheses_tried import Identified, identify_runs
from freerock.selection.reasons_after_fits import reasons_of_fits, reasons_of_noise

log = logging.getLogger("freerock")


def give_up_fits(settings: Mapping[str, Any], output: str | Path, reason: str) -> None:
    """Write the fits of a record in whose identification something unforeseen happened: none."""
    outcome = {"verdict": "fail", "reasons": [Reason.of("not_processed", reason)]}
    write_fits(output, {}, settings["attributes"] | outcome | {"not_fitted": [NotFitted(None, reason)]})


def make_fits(
    settings: Mapping[str, Any],
    record_file: str | Path,
    output: str | Path,
    identify: Callable[[Block, Mapping[int, Motion], Hypotheses], dict[int, Identified]] | None = None,
    passing: bool = False,
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
    identify : callable, optional
        What is identified of the runs of the record, as `identify_runs` does it: one that remembers spares
        the work on runs that have not changed.
    passing : bool
        Written to be looked at once: not compressed and without energies.
    """
    runs, impacts, motions, attrs = _read(record_file)
    block = Block(**settings["block"])
    hypotheses = Hypotheses(*(settings[key] for key in ("models", "kinematics", "free", "options")))
    laboratory = Laboratory.of(settings["laboratory"])
    motions = {number: replace(each, laboratory=laboratory) for number, each in motions.items()}
    found = (identify or identify_runs)(block, motions, hypotheses)
    choices: dict[int, Choice] = {number: each.choice(hypotheses) for number, each in found.items()}
    not_fitted = _report(found, choices, settings["attributes"]["test"])
    limits = ImpactLimits(**settings["impacts"])
    fits = {number: _in_order(each) for number, each in found.items() if each.fits}
    for number, of_run in fits.items():
        motion, widened = motions[number], found[number].widened
        for model, fit in of_run.items():
            fit = _with_impacts(fit, block, limits)
            fit = with_contributions(fit, motion, laboratory, hypotheses.settings(model, widened))
            if fit.success and not passing:
                fit = _with_energies(fit, block, motion, laboratory, hypotheses)
            of_run[model] = fit
    attributes = settings["attributes"] | {key: attrs[key] for key in ("verdict", "reasons")}
    attributes |= {key: each for key, each in attrs.items() if str(key).startswith("sensor_")}
    if not_fitted:
        attributes["not_fitted"] = not_fitted
    attributes["provenance"] = provenance([record_file], settings)
    choices = {number: choice for number, choice in choices.items() if number in fits}
    reasons = {
        number: [
            *(reasons_of_noise(motions[number]) if each.fits else []),
            *reasons_of_fits(runs[number].verdict, block, motions[number], each, hypotheses),
        ]
        for number, each in found.items()
    }
    for number, own in reasons.items():
        for reason in own:
            log.info("run %d: %s", number, reason.text)
    energies = dict[int, ImpactEnergy]()
    for number, choice in choices.items():
        named = fits[number].get(choice.selected)
        if named is not None and named.energies is not None:
            since_s = impacts[number].time_s - runs[number].release_s
            energies[number] = of_measured(named.energies, since_s)
    write_fits(output, fits, attributes, choices, reasons, not passing, energies)


def _read(
    record_file: str | Path,
) -> tuple[dict[int, Run], dict[int, Impacts], dict[int, Motion], Mapping[Any, Any]]:
    """Runs with their impacts, their motions, and the record's attributes; its samples are let go."""
    record = open_record(record_file, samples=False)
    runs = {run.number: run for run in runs_in(record) if run.verdict.level != "fail" and not run.excluded}
    motions = measured_in(record, samples_in(record_file, OVER_TIME))
    impacts = {number: impacts_in(group) for number, group in runs_of(record).items()}
    return runs, impacts, {number: each for number, each in motions.items() if number in runs}, record.attrs


def _report(found: Mapping[int, Identified], choices: Mapping[int, Choice], test: str) -> list[NotFitted]:
    """Log what was found of each run; the laws of the campaign to which the data allow no fit."""
    missed = []
    for number, each in found.items():
        for model, fit in each.fits.items():
            log.info("run %d, %s: ε_θ = %.4g, %s", number, model, fit.epsilon_theta, fit.message)
            log.info("%s", lmfit.fit_report(fit.result))
        for model, error in each.errors.items():
            if not CANDIDATES[model].is_rival:
                log.error("%s: %s: %s", test, model, error)
                missed.append(NotFitted(number, f"{model} not fitted: {error}"))
        choice = choices[number]
        log.info("run %d: %s: %s", number, choice.selected or "no candidate", choice.reason)
    return missed


def _in_order(found: Identified) -> dict[str, Fit]:
    """The fits of a run in the order of the models."""
    return {model: found.fits[model] for model in MODELS if model in found.fits}


def _with_impacts(fit: Fit, block: Block, limits: ImpactLimits) -> Fit:
    """The fit with the impacts of the modelled motion."""
    theta0 = fit.values.get("theta0", fit.theta_model[0])
    impacts = find_impacts(fit.time, fit.theta_model, 0.0, block, theta0=theta0, limits=limits)
    return replace(fit, impacts=impacts)


def _with_energies(
    fit: Fit, block: Block, motion: Motion, laboratory: Laboratory, hypotheses: Hypotheses
) -> Fit:
    """A fit to be used with the energies at its impacts, where it is of a foundation's law."""
    if fit.impacts is None or not law_of(fit.model).is_foundation:
        return fit
    debonding = hypotheses.settings(fit.model).debonding
    times, view = fit.impacts.time_s, motion.view
    if (at := _as_found(fit, laboratory)) is not laboratory:
        laboratory, block, view = at, at.block, view_of([*at.lasers.values()], at.block)
    found = impact_energy(fit, block, times, debonding=debonding, view=view, laboratory=laboratory)
    return replace(fit, energies=found)


def _as_found(fit: Fit, laboratory: Laboratory) -> Laboratory:
    """The laboratory with its inputs as a fit found them; as stated where it moved none."""
    if fit.contributions is None or not fit.contributions.moved.any():
        return laboratory
    return laboratory.at(fit.contributions.inputs, fit.contributions.moved)
