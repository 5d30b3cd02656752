"""A record is processed and fitted again with corrections, by the workflow's jobs and with their settings.

What a job would write is written to a folder of its own and read back: what is seen at the desk is what
`snakemake` will write. Rotations and fits that a correction does not touch are remembered, in files: ten
minutes at 10 kHz would take 200 MB of memory each time.
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from freerock.config.campaign import Campaign
from freerock.config.record import Record
from freerock.config.step_settings import fit_settings, record_settings
from freerock.errors import FreerockError
from freerock.products.netcdf import open_fits, open_record
from freerock.products.netcdf_groups import SINGLE_PRECISION
from freerock.products.provenance import provenance
from freerock.review.remembered import Remembered

ROTATIONS = 1  # remembered: that of the record on the desk
FITS = 12  # runs whose fits are remembered: some ten megabytes each
SETTINGS_BY_HAND = ("overrides", "exclusions", "stretches", "excluded")


class Superseded(Exception):
    """Something newer was requested meanwhile."""


class Analysed(NamedTuple):
    """The datasets of a record, without what runs over time, and of its fits, None where none were made."""

    record: xr.DataTree
    fits: xr.DataTree | None


class Bench:
    """Processes the records of a campaign again.

    Parameters
    ----------
    checksums : mapping of str to str
        SHA-256 of the record files as the manifest lists them.
    """

    def __init__(self, checksums: Mapping[str, str]):
        self._checksums = checksums
        self._rotations, self._identified = map(Remembered, (ROTATIONS, FITS))
        self._rotating = Lock()

    def settings(self, campaign: Campaign, line: Record) -> tuple[dict[str, Any], dict[str, Any]]:
        """What the jobs of a record get: of its rotation and runs, and of its fits."""
        listed = self._checksums.get(line.file, "")
        return record_settings(campaign, line, listed), fit_settings(campaign, line)

    def is_current(self, campaign: Campaign, line: Record, tree: xr.DataTree, step: int = 0) -> bool:
        """Whether a product is one of the settings and the software of now; step 0: record, 1: fits."""
        made_by = json.loads(tree.attrs.get("provenance", "{}"))
        if made_by.get("software") != provenance([], {})["software"]:
            return False
        then, now = made_by["config"], json.loads(json.dumps(self.settings(campaign, line)[step]))
        return all(then.get(key) == now.get(key) for key in {*then, *now} - {"attributes"})

    def rotate(self, campaign: Campaign, line: Record) -> None:
        """Remember the rotation of a record, so that its first correction is as quick as the next."""
        self._rotation(self.settings(campaign, line)[0])

    def signals(self, campaign: Campaign, line: Record) -> xr.Dataset:
        """A record whose runs are not known, over time [s]: its rotation, else its channels as in the file.

        Raises
        ------
        FreerockError
            The file can't be read.
        """
        from freerock.records.read import read_record

        try:
            return self._rotation(self.settings(campaign, line)[0])
        except FreerockError:
            path = Path(campaign.raw, line.file)
            known = campaign.processing.rotation
            channels = [
                read_record(path, name or None, time_unit=known.time_unit, rate_hz=known.sampling_rate_hz)
                for name in line.channels
            ]
        first, *more = channels
        for n, each in enumerate(more, 2):
            if np.array_equal(each["time"].values, first["time"].values):
                first = first.assign({f"{name}_{n}": each[name] for name in each.data_vars})
        return first

    def process(self, campaign: Campaign, line: Record) -> Analysed:
        """The record without its fits."""
        with TemporaryDirectory(prefix="freerock-review-") as folder:
            return Analysed(self._record(self.settings(campaign, line)[0], Path(folder, "record.nc")), None)

    def analyse(
        self,
        campaign: Campaign,
        line: Record,
        near_s: float | None = None,
        needed: Callable[[], bool] = lambda: True,
    ) -> Analysed:
        """The record and its fits.

        Parameters
        ----------
        campaign : Campaign
        line : Record
            With the corrections that are tried.
        near_s : float, optional
            Fit only the run whose release is the nearest [s].
        needed : callable
            Asked before each run is fitted.

        Raises
        ------
        Superseded
            It is no longer needed.
        FreerockError
            The machine lacks something, such as space for what is written meanwhile.
        """
        from freerock.jobs.make_fits import make_fits
        from freerock.selection.identify import Identified, identify_record

        def identify(block: Any, motions: Mapping[int, Any], allowed: Any) -> Identified:
            if not needed():
                raise Superseded
            if near_s is not None:
                nearest = min(motions, key=lambda number: abs(release[number] - near_s), default=None)
                motions = {} if nearest is None else {nearest: motions[nearest]}
            key = block, tuple(motions.items()), allowed
            found = self._identified.get(key, lambda: identify_record(block, motions, allowed))
            assert isinstance(found, Identified)
            return found

        of_record, of_fits = self.settings(campaign, line)
        with TemporaryDirectory(prefix="freerock-review-") as folder:
            record_file, fits_file = Path(folder, "record.nc"), Path(folder, "fits.nc")
            record = self._record(of_record, record_file)
            runs = record.children.values()
            release = {int(run.attrs["run"]): run.dataset["release"].item() for run in runs}
            if not needed():
                raise Superseded
            make_fits(of_fits, record_file, fits_file, identify)
            return Analysed(record, open_fits(fits_file))

    def _record(self, settings: Mapping[str, Any], file: Path) -> xr.DataTree:
        from freerock.jobs.make_record import make_record

        make_record(settings, file, self._rotation)
        return open_record(file, samples=False)

    def _rotation(self, settings: Mapping[str, Any]) -> xr.Dataset:
        from freerock.rotation.rotation import rotation_of

        own = {
            key: value
            for key, value in settings.items()
            if key not in (*SETTINGS_BY_HAND, "attributes", "laboratory")
        }
        look = Path(settings["raw"], settings["file"])
        stamp = (look.stat().st_mtime_ns, look.stat().st_size) if look.is_file() else ()
        with self._rotating:
            found = self._rotations.get((own, stamp), lambda: as_written(rotation_of(settings)))
        assert isinstance(found, xr.Dataset)
        return found


def as_written(rotation: xr.Dataset) -> xr.Dataset:
    """A rotation with what was recorded in single precision, as products have it."""
    recorded = SINGLE_PRECISION & set(rotation.data_vars) - {"sigma_theta"}
    return rotation.assign({name: rotation[name].astype(np.float32) for name in recorded})
