"""The models identified on each run of one record, and on all its runs jointly."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from freerock.errors import FreerockError
from freerock.identification.choice import choose, is_wanted
from freerock.identification.fit import Fit, evidence, fit_record
from freerock.identification.settings import FitSettings
from freerock.models.block import Block
from freerock.models.laws import MODELS, law_of
from freerock.products.groups import NotFitted
from freerock.products.netcdf import open_record, write_fits
from freerock.products.provenance import provenance
from freerock.products.runs import motions_in, runs_in
from freerock.runs.impacts import find_impacts
from freerock.runs.limits import ImpactLimits
from freerock.runs.motion import Motion
from freerock.runs.verdict import Reason

log = logging.getLogger("freerock")


def give_up(settings: Mapping[str, Any], output: str | Path, reason: str) -> None:
    """Write the fits of a record in whose identification something unforeseen happened: none."""
    outcome = {"verdict": "fail", "reasons": [Reason("fail", "not_processed", reason)]}
    write_fits(output, {}, {}, settings["attributes"] | outcome | {"not_fitted": [NotFitted(None, reason)]})


def make_fits(settings: Mapping[str, Any], record_file: str | Path, output: str | Path) -> None:
    """Write the fits of a record.

    Parameters
    ----------
    settings : mapping
        block, attributes, models, kinematics (of the rivals), free (by law), pooled, options (of
        `FitSettings`), impacts: sections of the configuration as plain values.
    record_file : path
        Dataset of the record.
    output : path
        netCDF file to write; without groups where no run can be fitted. The joint fit of a single run is
        that run's.
    """
    record = open_record(record_file)
    usable = {run.number for run in runs_in(record) if run.verdict.level != "fail" and not run.excluded}
    motions = {
        number: motion for number, motion in motions_in(record, with_noise=True).items() if number in usable
    }
    fitter = _Fitter(settings, Block(**settings["block"]))
    fits = {number: found for number, motion in motions.items() if (found := fitter.of_run(number, motion))}
    pooled = fitter.jointly(motions, fits) if settings["pooled"] else {}
    attributes = settings["attributes"] | {key: record.attrs[key] for key in ("verdict", "reasons")}
    if fitter.not_fitted:
        attributes["not_fitted"] = fitter.not_fitted
    attributes["provenance"] = provenance([record_file], settings)
    made: list[tuple[int | str, dict[str, Fit]]] = [*fits.items(), *([("pooled", pooled)] if pooled else [])]
    choices = {run: choose([evidence(fit) for fit in models.values()]) for run, models in made}
    write_fits(output, fits, pooled, attributes, choices)


@dataclass(frozen=True)
class _Fitter:
    """Fits models to the runs of one record, and notes what could not be fitted.

    Parameters
    ----------
    settings : mapping
        Those of `make_fits`.
    block : Block
    not_fitted : list of NotFitted
        Grows with each fit that the data do not allow.
    """

    settings: Mapping[str, Any]
    block: Block
    not_fitted: list[NotFitted] = field(default_factory=list)

    def of_run(self, number: int, motion: Motion) -> dict[str, Fit]:
        """The models of one run; a law with cases only where the others ask for it."""
        found: dict[str, Fit] = {}
        for model in sorted(self.settings["models"], key=lambda model: len(law_of(model).cases)):
            if is_wanted(model, {name: evidence(fit) for name, fit in found.items()}):
                fit = self._fit(model, number, [motion])
                found |= {model: fit} if fit else {}
        return {model: self._with_impacts(fit) for model, fit in found.items()}

    def jointly(self, motions: Mapping[int, Motion], fits: Mapping[int, Mapping[str, Fit]]) -> dict[str, Fit]:
        """The models that were fitted to any run, on all runs together; they start from the mean of these."""
        models = self.settings["models"]
        if len(motions) == 1:
            own = next(iter(fits.values()), {})
            return {model: replace(own[model], impacts=None) for model in models if model in own}
        pooled: dict[str, Fit] = {}
        for model in models:
            alone = [each[model] for each in fits.values() if model in each]
            n = len(MODELS[model])
            values = [fit.value[:n] for fit in alone if fit.success]
            start = (sum(values, np.zeros(n)) / len(values)).tolist() if values else None
            fit = self._fit(model, "pooled", list(motions.values()), start) if alone else None
            pooled |= {model: fit} if fit else {}
        return pooled

    def _fit(
        self,
        model: str,
        run: int | Literal["pooled"],
        motions: Sequence[Motion],
        start: Sequence[float] | None = None,
    ) -> Fit | None:
        """The fit, or None where the data allow none; the log and the product say why."""
        settings = FitSettings(free=self.settings["free"][model], **self.settings["options"])
        try:
            fit = fit_record(model, self.block, motions, settings, start=start)
        except FreerockError as error:
            log.error("%s: %s: %s", self.settings["attributes"]["test"], model, error)
            self.not_fitted.append(NotFitted(run, f"{model} not fitted: {error}"))
            return None
        log.info("%s: ε_θ = %.4g, %s", model, fit.epsilon_theta, fit.message)
        return fit

    def _with_impacts(self, fit: Fit) -> Fit:
        """The fit with the impacts of the modelled motion."""
        theta0 = dict(zip(fit.parameters, fit.value, strict=True)).get("theta0", fit.theta_model[0])
        limits = ImpactLimits(**self.settings["impacts"])
        impacts = find_impacts(fit.time, fit.theta_model, 0.0, self.block, theta0=theta0, limits=limits)
        return replace(fit, impacts=impacts)
