"""A record file to θ(t), runs and impacts."""

import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from freerock.errors import FreerockError
from freerock.files import check_file
from freerock.jobs.each import of_the_machine
from freerock.models.block import Block
from freerock.products.netcdf import write_failure, write_record
from freerock.products.provenance import provenance
from freerock.records.read import read_record
from freerock.rotation.calibration import read_calibration
from freerock.rotation.faults import listed_faults
from freerock.rotation.options import RotationOptions
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.impacts import doubt_about, find_impacts
from freerock.runs.segment import find_runs
from freerock.runs.verdict import Reason

log = logging.getLogger("freerock")


def make_record(settings: Mapping, output: str | Path) -> None:
    """Write the dataset of a record; of one that can't be processed, with the verdict fail and the reason.

    Parameters
    ----------
    settings : mapping
        raw (folder), file, sha256 (as listed), channels, attributes, block, lasers, rotation, runs, impacts,
        overrides, exclusions, excluded (a reason, or empty): sections of the configuration as plain values.
    output : path
        netCDF file to write.
    """
    path = Path(settings["raw"], settings["file"])
    attributes = settings["attributes"] | {"provenance": provenance([], settings)}
    try:
        attributes["provenance"] = provenance(filter(Path.exists, _files(settings)), settings)
        processed = None if settings["excluded"] else _process(settings, path)
    except FreerockError as error:
        if of_the_machine(error):
            raise
        where = str(error.where) if str(path) in str(error.where) else f"{path}: {error.where}"
        failure = FreerockError(where, error.what, error.remedy)
        log.error(failure)
        write_failure(output, Reason("fail", "not_processed", str(failure)), attributes)
        return
    if processed is None:
        excluded = Reason("warn", "excluded", f"excluded: {settings['excluded']}")
        write_failure(output, excluded, attributes)
        return
    record, runs, impacts = processed
    write_record(output, record, runs, impacts, attributes)
    for key in ("reading", "time_base"):
        if key in record.attrs:
            log.info("%s: %s", key.replace("_", " "), record.attrs[key])
    for fault in listed_faults(record):
        log.info("%s from %.3f s to %.3f s: %s", fault.name, fault.start_s, fault.end_s, fault.note)
    for run in runs:
        verdict = ": ".join([run.verdict.level, *run.verdict.texts])
        log.info("run %d, released at %.3f s: %s", run.number, run.release_s, verdict)


def _files(settings):
    """The record file and the calibration tables of its lasers."""
    tables = [each["calibration"] for each in settings["lasers"] if each["calibration"]]
    return [Path(settings["raw"], file) for file in [settings["file"], *tables]]


def _process(settings, path):
    if settings["sha256"]:
        check_file(settings["raw"], settings["file"], settings["sha256"])
    block = Block(**settings["block"])
    lasers = [_sensor(section, settings["raw"]) for section in settings["lasers"]]
    times, signals, units, told = zip(*(_channel(path, name) for name in settings["channels"]), strict=True)
    if not all(np.array_equal(time, times[0]) for time in times):
        raise FreerockError(path, "the two channels differ in their times", "name two of one group")
    record = find_rotation(times[0], signals, lasers, block, units, RotationOptions(**settings["rotation"]))
    record.attrs |= told[0]
    time, theta, sigma, flags = (record[name].values for name in ("time", "theta", "sigma_theta", "flags"))
    known = block, record.attrs["zero_stderr_rad"], listed_faults(record)
    by_hand = {key: settings[key] for key in ("overrides", "exclusions")}
    runs = find_runs(time, theta, sigma, flags, *known, **by_hand, **settings["runs"])
    impacts = []
    for run in runs:
        during = slice(np.searchsorted(time, run.release_s), np.searchsorted(time, run.end_s, "right"))
        held = {"theta0": run.theta0, "theta0_stderr": run.theta0_stderr}
        impacts.append(
            find_impacts(time[during], theta[during], sigma[during], block, **held, **settings["impacts"])
        )
    ratio = settings["impacts"]["min_uplift_ratio"]
    judged = [
        replace(run, verdict=run.verdict.adding(doubt_about(found, min_uplift_ratio=ratio)))
        for run, found in zip(runs, impacts, strict=True)
    ]
    return record, judged, impacts


def _sensor(section, raw):
    table = section["calibration"] and read_calibration(Path(raw, section["calibration"]))
    return Laser(**section | {"calibration": table})


def _channel(path, name):
    """A channel by its name, "" for the only one: time, signal, unit, and what its reader found out."""
    read = read_record(path, name or None)
    if len(read.data_vars) > 1:
        several = f"has the channels {', '.join(read.data_vars)}"
        raise FreerockError(path, several, "name one in the channel column of the campaign's CSV")
    (signal,) = read.data_vars.values()
    told = {key: read.attrs[key] for key in ("reading", "time_base") if key in read.attrs}
    return read["time"].values, signal.values, signal.attrs["units"], told
