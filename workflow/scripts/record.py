"""Volts of one record to θ(t), runs and impacts."""

from pathlib import Path

from freerock.acquisition import read_record
from freerock.datasets import provenance, write_failure, write_record
from freerock.errors import FreerockError
from freerock.impacts import find_impacts
from freerock.laser import Laser, rotation
from freerock.manifest import check_manifest
from freerock.models.block import Block
from freerock.runs import find_runs
from freerock.workflow import log_to

VOLTS = ("", "v", "volt", "volts")  # as the file states it, or not

log = log_to(snakemake.log[0])
params = snakemake.params
path = Path(params.raw, params.file)
block, laser = Block(**params.block), Laser(**params.laser)


def process():
    check_manifest(params.raw, [params.file])
    volts = read_record(path, params.channel or None)
    if len(volts.data_vars) > 1:
        several = f"has the channels {', '.join(volts.data_vars)}"
        raise FreerockError(path, several, "name one in the channel column of the campaign's CSV")
    (signal,) = volts.data_vars.values()
    if signal.attrs["units"].casefold() not in VOLTS:
        what = f"channel {signal.name!r} is in {signal.attrs['units']!r}"
        raise FreerockError(path, what, "name the channel that holds the laser's volts, or set its unit to V")
    record = rotation(volts["time"].values, signal.values, laser, block, **params.rotation)
    time, theta, sigma, flags = (record[name].values for name in ("time", "theta", "sigma_theta", "flags"))
    by_hand = {"overrides": params.overrides, "exclusions": params.exclusions}
    zero_stderr = record.attrs["zero_stderr_rad"]
    runs = find_runs(time, theta, sigma, flags, block, zero_stderr, **by_hand, **params.runs)
    impacts = []
    for run in runs:
        during = (time >= run.release_s) & (time <= run.end_s)
        held = {"theta0": run.theta0, "theta0_stderr": run.theta0_stderr}
        impacts.append(
            find_impacts(time[during], theta[during], sigma[during], block, **held, **params.impacts)
        )
    return record, runs, impacts


output = snakemake.output.record
settings = dict(params.items())
attributes = params.attributes | {"provenance": provenance([], settings)}
try:
    attributes["provenance"] = provenance(snakemake.input.raw, settings)
    if params.excluded:
        write_failure(output, f"excluded: {params.excluded}", attributes, verdict="warn")
    else:
        record, runs, impacts = process()
        write_record(output, record, runs, impacts, attributes)
        for run in runs:
            log.info(
                "run %d, released at %.3f s: %s",
                run.number,
                run.release_s,
                ": ".join([run.verdict, *run.reasons]),
            )
except FreerockError as error:
    where = str(error.where) if str(path) in str(error.where) else f"{path}: {error.where}"
    failure = FreerockError(where, error.what, error.remedy)
    log.error(failure)
    write_failure(output, failure, attributes)
