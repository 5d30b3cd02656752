"""A record file in one call, for scripts and notebooks: θ(t), its runs, their impacts and fits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import Any

import xarray as xr

from freerock.config.fit_settings import FIT_SETTINGS, FitSettings
from freerock.config.input_uncertainties import inputs_of
from freerock.config.mistakes import refuse, validate
from freerock.config.processing import RotationOptions
from freerock.errors import FreerockError, of_kind
from freerock.identification.fit import fit_record
from freerock.identification.fitted import Fit
from freerock.models.block import Block
from freerock.models.laws import PAPER_MODELS
from freerock.rotation.laboratory import UNITS, Input, Laboratory
from freerock.rotation.rotation import rotation_in
from freerock.rotation.sensor import Laser, lasers_of
from freerock.rotation.view import view_of
from freerock.runs.impacts import Impacts
from freerock.runs.motion import Motion, motions_of
from freerock.runs.runs import Measured, Run, measured
from freerock.selection.candidates import Allowed
from freerock.selection.identify import identify_record


@dataclass(frozen=True, eq=False)
class LoadedRun:
    """A run of a record that `load` has read.

    Parameters
    ----------
    found : Run
        Release, end and verdict.
    impacts : Impacts
    motion : Motion
        What a fit takes: θ(t) since the release, the noise at rest, the sensor, the laboratory.
    record : LoadedRecord
    """

    found: Run
    impacts: Impacts
    motion: Motion
    record: "LoadedRecord"

    def __repr__(self) -> str:
        run, level = self.found, self.found.verdict.level
        return f"run {run.number}, released at {run.release_s:.3f} s: {level}, {run.n_impacts} impacts"

    def fit(self, law: str, settings: FitSettings = FIT_SETTINGS) -> Fit:
        """The fit of a law to this run, as the workflow has it: beside the other runs of its record.

        Raises
        ------
        FreerockError
            As of `freerock.fit_record`; or the run can't be used.
        """
        fits = self.record.fit(law, settings)
        if self.found.number not in fits:
            where, why = f"run {self.found.number}", "; ".join(self.found.verdict.texts)
            raise FreerockError(where, f"can't be used: {why}", "see docs/verdicts.md")
        return fits[self.found.number]


@dataclass(frozen=True, eq=False)
class LoadedRecord:
    """A record that `load` has read.

    Parameters
    ----------
    data : xarray.Dataset
        θ(t), its noise and its flags over time, as `freerock.find_rotation` gives them.
    block : Block
    motions : mapping of int to Motion
        Of each run by its number.
    found : Measured
        Runs, their impacts, and the noise at rest.
    """

    data: xr.Dataset
    block: Block
    motions: Mapping[int, Motion]
    found: Measured
    _fits: dict[str, dict[int, Fit]] = field(default_factory=dict, init=False)

    def __repr__(self) -> str:
        return "\n".join(map(str, self.runs))

    @property
    def theta(self) -> xr.DataArray:
        """Rotation [rad] over time [s], shape (n_time,)."""
        return self.data["theta"]

    @property
    def runs(self) -> tuple[LoadedRun, ...]:
        """The runs, from release to rest."""
        each = zip(self.found.runs, self.found.impacts, strict=True)
        return tuple(LoadedRun(run, own, self.motions[run.number], self) for run, own in each)

    def fit(self, law: str, settings: FitSettings = FIT_SETTINGS) -> dict[int, Fit]:
        """The fits of a law to all runs that can be used, by their number; see `freerock.fit_record`.

        The laws of the paper are sought beside each other, as in the workflow: the search of one that is far
        from the runs ends early.
        """
        of_kind("settings", settings, FitSettings, "give freerock.FitSettings(...)")
        key = f"{law} {settings}"
        if key not in self._fits:
            usable = {
                run.number: self.motions[run.number] for run in self.found.runs if run.verdict.level != "fail"
            }
            if law in PAPER_MODELS:
                options = {"debonding": settings.debonding, "parameters": settings.parameters}
                allowed = Allowed(PAPER_MODELS, (), dict.fromkeys(PAPER_MODELS, settings.free), options)
                found = identify_record(self.block, usable, allowed).fits
                self._fits.update({f"{name} {settings}": fits for name, fits in found.items()})
            if key not in self._fits:
                self._fits[key] = fit_record(law, self.block, usable, settings)
        return self._fits[key]


def load(
    file: str | Path,
    block: Block,
    laser: Laser | Sequence[Laser],
    channel: str | Sequence[str] = "",
    uncertainty: Mapping[str, float] | None = None,
    **options: Any,
) -> LoadedRecord:
    """Read a record file: θ(t), its runs and their impacts, as the workflow finds them.

    Parameters
    ----------
    file : path
        Of any format that `freerock.read_record` reads.
    block : Block
    laser : Laser or sequence of two Laser
    channel : str or sequence of two str, optional
        Of each laser; needed where the file holds several.
    uncertainty : mapping of str to float, optional
        Standard uncertainties of block and laser, by the keys of `uncertainty` in a campaign, such as
        `mass_kg` or `position_m`; 0 is exact. What is left out has the default of a campaign.
    **options
        Of `freerock.RotationOptions`, such as `sampling_rate_hz`, where the file states none.

    Raises
    ------
    FreerockError
        The file can't be read, holds several channels of which none is named, or shows no rest; an
        uncertainty of nothing that is known.

    Examples
    --------
    >>> import freerock
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> laser = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)
    >>> record = freerock.load("raw/palermo_virtual/config2_marble.tdms", block, laser)
    >>> record
    run 1, released at 5.830 s: ok, 46 impacts
    run 2, released at 19.529 s: ok, 46 impacts
    run 3, released at 34.480 s: ok, 44 impacts
    """
    of_kind("block", block, Block, "give freerock.Block(...)")
    lasers = lasers_of(laser)
    names = (channel,) if isinstance(channel, str) else tuple(channel)
    laboratory = _laboratory(block, lasers, uncertainty or {})
    mistakes = list[FreerockError]()
    how = validate(RotationOptions, options, lambda loc: ".".join(map(str, loc)), mistakes)
    refuse(mistakes)
    data = rotation_in(Path(file), names, lasers, block, how)
    found = measured(data, block)
    samples = {name: data[name].values for name in ("time", "theta", "sigma_theta")}
    motions = motions_of(found.runs, samples, view_of(lasers, block), found.noise)
    motions = {number: replace(each, laboratory=laboratory) for number, each in motions.items()}
    return LoadedRecord(data, block, motions, found)


def _laboratory(block: Block, lasers: Sequence[Laser], given: Mapping[str, float]) -> Laboratory:
    """Block and lasers with their uncertainties, as given or by default."""
    if unknown := {*given} - {*UNITS}:
        raise FreerockError("uncertainty", f"unknown key {min(unknown)!r}", f"use {', '.join(UNITS)}")
    for key, u in given.items():
        if not (isinstance(u, Real) and u >= 0):
            remedy = f"give it in {UNITS[key]}; 0 is exact"
            raise FreerockError(f"uncertainty.{key}", f"{u!r} is no positive number", remedy)
    owners = {"laser" if i == 0 else "laser_2": each for i, each in enumerate(lasers)}
    inputs = inputs_of(("block", block), owners, dict.fromkeys(("block", *owners), given))
    return Laboratory(block, owners, tuple(Input(**each) for each in inputs))
