"""A record file in one call, for scripts and notebooks: θ(t), its runs, their impacts and fits."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.fit import Fit, fit_run
from freerock.models.block import Block
from freerock.noise.at_rest import noise_at_rest, quiet_stretches
from freerock.records.read import read_record
from freerock.rotation.faults import signal_quality
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.rotation.view import view_of
from freerock.runs.impacts import Impacts
from freerock.runs.motion import Motion, heard, motion_of
from freerock.runs.runs_with_impacts import runs_with_impacts
from freerock.runs.segment import Run


@dataclass(frozen=True, eq=False)
class LoadedRun:
    """A run of a record that `load` has read.

    Parameters
    ----------
    found : Run
        Release, end and verdict.
    impacts : Impacts
    block : Block
    motion : Motion
        What a fit takes: θ(t) since the release, the noise at rest, the view of the sensor.
    """

    found: Run
    impacts: Impacts
    block: Block
    motion: Motion

    def fit(self, law: str, settings: FitSettings | None = None) -> Fit:
        """Identify a law on this run alone, its impacts free to scatter; see `freerock.fit_run`."""
        return fit_run(law, self.block, self.motion, settings)


@dataclass(frozen=True, eq=False)
class LoadedRecord:
    """A record that `load` has read.

    Parameters
    ----------
    data : xarray.Dataset
        θ(t), its noise and its flags over time, as `freerock.find_rotation` gives them.
    runs : tuple of LoadedRun
    """

    data: xr.Dataset
    runs: tuple[LoadedRun, ...]

    @property
    def theta(self) -> xr.DataArray:
        """Rotation [rad] over time [s], shape (n_time,)."""
        return self.data["theta"]


def load(file: str | Path, block: Block, laser: Laser, channel: str | None = None) -> LoadedRecord:
    """Read a record of one laser: θ(t), its runs and their impacts, as the workflow finds them.

    Block and laser count as exact; a campaign's configuration gives their uncertainties.

    Parameters
    ----------
    file : path
        Of any format that `freerock.read_record` reads.
    block : Block
    laser : Laser
    channel : str, optional
        Of the laser; needed where the file holds several.

    Raises
    ------
    FreerockError
        If the file can't be read, holds several channels and none is named, or shows no rest.
    """
    channels = read_record(file)
    names = ", ".join(map(str, channels))
    if channel is None and len(channels) > 1:
        raise FreerockError(str(file), f"it holds {len(channels)} channels", f"name one of {names}")
    name = channel or str(next(iter(channels)))
    if name not in channels:
        raise FreerockError(str(file), f"it has no channel {name!r}", f"name one of {names}")
    read = channels[name]
    data = find_rotation(read["time"].values, read.values, laser, block, read.units)
    time_s, theta, sigma, flags = (data[each].values for each in ("time", "theta", "sigma_theta", "flags"))
    quality, view = signal_quality(data), view_of([laser], block)
    rate_hz = (time_s.size - 1) / float(time_s[-1] - time_s[0])
    noise = noise_at_rest(quiet_stretches(time_s, theta, sigma), rate_hz, quality.converter_step)
    clean = np.where(flags > 0, np.nan, theta)
    found = runs_with_impacts([time_s, theta, sigma, flags], block, quality)
    runs = (
        LoadedRun(run, impacts, block, heard(motion_of(run, time_s, clean, view=view), noise))
        for run, impacts in found
    )
    return LoadedRecord(data, tuple(runs))
