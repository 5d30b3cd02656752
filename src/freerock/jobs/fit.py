"""The models identified on each run of one record, and on all its runs jointly."""

import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from freerock.errors import FreerockError
from freerock.identification.choice import is_wanted
from freerock.identification.fit import evidence, fit_record
from freerock.models.block import Block
from freerock.models.laws import LAWS, MODELS
from freerock.products.groups import NotFitted
from freerock.products.netcdf import open_record, write_fits
from freerock.products.provenance import provenance
from freerock.products.runs import motions_in, runs_in
from freerock.runs.impacts import find_impacts

log = logging.getLogger("freerock")


def make_fits(settings: Mapping, record_file: str | Path, output: str | Path) -> None:
    """Write the fits of a record.

    Parameters
    ----------
    settings : mapping
        block, attributes, models, free (by model), pooled, options (of `identify.fit_record`), impacts:
        sections of the configuration as plain values.
    record_file : path
        Dataset of the record.
    output : path
        netCDF file to write; without groups where no run can be fitted. The joint fit of a single run is
        that run's.
    """
    block, record = Block(**settings["block"]), open_record(record_file)
    models, impacts = settings["models"], settings["impacts"]

    not_fitted: list[NotFitted] = []

    def fit(model, run, motions, start=None):
        """The fit, or None where the data allow none; the log and the product say why."""
        try:
            free = settings["free"][model]
            found = fit_record(model, block, motions, start=start, free=free, **settings["options"])
        except FreerockError as error:
            log.error("%s: %s: %s", settings["attributes"]["test"], model, error)
            not_fitted.append(NotFitted(run, f"{model} not fitted: {error}"))
            return None
        log.info("%s: ε_θ = %.4g, %s", model, found.epsilon_theta, found.message)
        return found

    def fit_all(number, motion):
        """The models of one run; a law with cases only where the others ask for it."""
        found = {}
        for model in sorted(models, key=lambda model: len(LAWS[model].cases)):
            if is_wanted(model, {m: evidence(f) for m, f in found.items() if f}):
                found[model] = fit(model, number, [motion])
        return {model: _with_impacts(each, block, impacts) for model, each in found.items() if each}

    usable = {run.number for run in runs_in(record) if run.verdict.level != "fail" and not run.excluded}
    motions = {number: motion for number, motion in motions_in(record).items() if number in usable}
    fits = {number: found for number, motion in motions.items() if (found := fit_all(number, motion))}

    def joint(model):
        if len(motions) == 1:
            return replace(next(iter(fits.values()))[model], impacts=None)
        own = [each[model].value for each in fits.values() if model in each and each[model].success]
        start = sum(value[: len(MODELS[model])] for value in own) / len(own) if own else None
        return fit(model, "pooled", list(motions.values()), start)

    fitted = {model for each in fits.values() for model in each}
    pooled = {model: joint(model) for model in models if settings["pooled"] and model in fitted}
    pooled = {model: found for model, found in pooled.items() if found}
    attributes = settings["attributes"] | {key: record.attrs[key] for key in ("verdict", "reasons")}
    if not_fitted:
        attributes["not_fitted"] = not_fitted
    attributes["provenance"] = provenance([record_file], settings)
    write_fits(output, fits, pooled, attributes)


def _with_impacts(found, block, impacts):
    theta0 = dict(zip(found.parameters, found.value, strict=True)).get("theta0", found.theta_model[0])
    return replace(
        found, impacts=find_impacts(found.time, found.theta_model, 0.0, block, theta0=theta0, **impacts)
    )
