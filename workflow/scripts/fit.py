"""Models identified on each run of one record, and on all its runs jointly."""

from dataclasses import replace

from freerock.compare import wants_general
from freerock.datasets import open_record, provenance, runs_in, write_fits
from freerock.errors import FreerockError
from freerock.identify import Motion, evidence, fit_record
from freerock.impacts import find_impacts
from freerock.models import MODELS
from freerock.models.block import Block
from freerock.workflow import log_to

log = log_to(snakemake.log[0])
params = snakemake.params
block, record = Block(**params.block), open_record(snakemake.input.record)


def motion(run):
    time, theta = record["time"].values, record["theta"].values
    during = (time >= run.release_s) & (time <= run.end_s)
    return Motion(
        time[during] - run.release_s,
        theta[during],
        sigma_theta=run.sigma_theta,
        theta0=run.theta0,
        theta0_stderr=run.theta0_stderr,
        t0_stderr=run.release_stderr_s,
        start_s=run.start_s - run.release_s,
    )


def fit(model, motions, start=None):
    """The fit, or None where the data allow none; the log says why."""
    try:
        found = fit_record(model, block, motions, start=start, free=params.free[model], **params.options)
    except FreerockError as error:
        log.error("%s: %s", model, error)
        return None
    log.info("%s: ε_θ = %.4g, %s", model, found.epsilon_theta, found.message)
    return found


def made(fits):
    return {key: found for key, found in fits if found is not None}


def with_impacts(found):
    if found is None:
        return None
    theta0 = dict(zip(found.parameters, found.value, strict=True)).get("theta0", found.theta_model[0])
    impacts = find_impacts(found.time, found.theta_model, 0.0, block, theta0=theta0, **params.impacts)
    return replace(found, impacts=impacts)


def fit_all(motion):
    """The models of one run; the general law only where the others ask for it."""
    found = made((model, with_impacts(fit(model, [motion]))) for model in params.models if model != "general")
    if "general" in params.models and wants_general({m: evidence(f) for m, f in found.items()}):
        found |= made([("general", with_impacts(fit("general", [motion])))])
    return found


runs = [run for run in runs_in(record) if run.verdict != "fail" and not run.excluded]
motions = {run.number: motion(run) for run in runs}
fits = {number: found for number in motions if (found := fit_all(motions[number]))}


def joint(model):
    own = [each[model].value for each in fits.values() if model in each and each[model].success]
    start = sum(value[: len(MODELS[model])] for value in own) / len(own) if own else None
    return fit(model, list(motions.values()), start)


own = {model for each in fits.values() for model in each}
pooled = made((model, joint(model)) for model in params.models if params.pooled and model in own)
attributes = params.attributes | {key: record.attrs[key] for key in ("verdict", "reasons")}
attributes["provenance"] = provenance([snakemake.input.record], dict(params.items()))
write_fits(snakemake.output.fits, fits, pooled, attributes)
