"""A record file to θ(t), runs and impacts."""

import logging
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from freerock.config.processing import ImpactLimits, RunLimits
from freerock.errors import FreerockError
from freerock.jobs.log import of_the_machine
from freerock.models.block import Block
from freerock.products.netcdf import write_failure, write_record
from freerock.products.provenance import provenance
from freerock.rotation.flags import listed_faults
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.rotation import READERS_NOTES, rotation_of
from freerock.runs.hand_corrections import ByHand
from freerock.runs.runs import Run, measured
from freerock.runs.u_of_measured import measured_total
from freerock.runs.verdict import Reason

log = logging.getLogger("freerock")

Settings = Mapping[str, Any]


def give_up_record(settings: Settings, output: str | Path, reason: str) -> None:
    """Write the dataset of a record in whose processing something unforeseen happened."""
    write_failure(output, Reason.of("not_processed", reason), settings["attributes"])


def make_record(
    settings: Settings,
    output: str | Path,
    rotate: Callable[[Settings], xr.Dataset] = rotation_of,
) -> None:
    """Write the dataset of a record; of one that can't be processed, with the verdict fail and the reason.

    Parameters
    ----------
    settings : mapping
        raw (folder), file, sha256 (as listed), channels, attributes, block, lasers, laboratory, rotation,
        runs, impacts, overrides, exclusions, stretches, excluded (a reason, or empty): sections of the
        configuration as plain values.
    output : path
        netCDF file to write.
    rotate : callable, optional
        Gives θ(t) of the record: one that remembers spares the work while only release and end of runs
        change.
    """
    path, record = Path(settings["raw"], settings["file"]), None
    attributes = settings["attributes"] | {"provenance": provenance([], settings)}
    tables = [each["calibration"] for each in settings["lasers"] if each["calibration"]]
    files = [Path(settings["raw"], file) for file in [settings["file"], *tables]]
    try:
        attributes["provenance"] = provenance([file for file in files if file.exists()], settings)
        if settings["excluded"]:
            write_failure(output, Reason.of("excluded", f"excluded: {settings['excluded']}"), attributes)
            return
        by_hand = ByHand(settings["overrides"], settings["exclusions"], settings.get("stretches", ()))
        record = rotate(settings)
        if by_hand.stretches:
            record = by_hand.without_hidden(record)
        limits = RunLimits(**settings["runs"]), ImpactLimits(**settings["impacts"])
        found = measured(record, Block(**settings["block"]), by_hand, *limits)
        laboratory = Laboratory.of(settings["laboratory"])
        totals = [
            measured_total(run.theta0, run.theta0_stderr, own, laboratory)
            for run, own in zip(found.runs, found.impacts, strict=True)
        ]
    except FreerockError as error:
        if of_the_machine(error):
            raise
        where = str(error.where) if str(path) in str(error.where) else f"{path}: {error.where}"
        failure = FreerockError(where, error.what, error.remedy)
        log.error(failure)
        write_failure(output, Reason.of("not_processed", str(failure)), attributes, record)
        return
    write_record(output, record, found, totals, attributes)
    _log(record, found.runs)


def _log(record: xr.Dataset, runs: Sequence[Run]) -> None:
    """What was found, for the record's log."""
    for key in READERS_NOTES:
        if key in record.attrs:
            log.info("%s: %s", key.replace("_", " "), record.attrs[key])
    for fault in listed_faults(record):
        log.info("%s from %.3f s to %.3f s: %s", fault.name, fault.start_s, fault.end_s, fault.note)
    for run in runs:
        verdict = ": ".join([run.verdict.level, *run.verdict.texts])
        log.info("run %d, released at %.3f s: %s", run.number, run.release_s, verdict)
