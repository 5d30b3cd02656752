"""Settings of a fit that are refused, and what others free."""

from collections.abc import Sequence

from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError, of_kind
from freerock.models.block import Block
from freerock.models.given import faults
from freerock.models.laws import CANDIDATES, DEBONDING, GEOMETRIC, LAWS, law_of


def freed(model: str, free: Sequence[str]) -> tuple[str, ...]:
    """What is fitted besides the parameters of a candidate, of which some free the width themselves.

    Edges are sharp where rounded ones are not implemented.
    """
    kept = tuple(name for name in free if name != "edge_radius" or name in law_of(model).may_free)
    return ("width", *kept) if CANDIDATES[model].width and "width" not in kept else kept


def check(model: str, block: Block, settings: FitSettings) -> None:
    """Refuse a fit that has no meaning.

    Parameters
    ----------
    model : str
    block : Block
    settings : FitSettings

    Raises
    ------
    FreerockError
        Unknown model or nuisance; what is given of a parameter is wrong, or leaves nothing to fit; debonding
        that is not implemented for the model.
    """
    of_kind("block", block, Block, "give freerock.Block(...)")
    of_kind("settings", settings, FitSettings, "give freerock.FitSettings(...)")
    if model not in CANDIDATES:
        raise FreerockError("fits.models", f"unknown model {model!r}", f"use one of {', '.join(CANDIDATES)}")
    name = CANDIDATES[model].law
    law, key = LAWS[name], f"fits.free.{name}"
    known = tuple(dict.fromkeys(name for law in LAWS.values() for name in law.may_free))
    unknown = set(settings.free) - {*known, "release"}
    if unknown:
        remedy = f"use {', '.join(known[:-1])} or {known[-1]}"
        raise FreerockError(key, f"unknown nuisance {min(unknown)!r}", remedy)
    given = settings.given(model)
    for parameter, what, remedy in faults(name, given):
        raise FreerockError(f"fits.parameters.{name}.{parameter}", what, remedy)
    if not freed(model, settings.free) and not any(
        each not in given or given[each].varies for each in law.parameters
    ):
        raise FreerockError(f"fits.parameters.{name}", "no parameter is free", "free one")
    if settings.debonding not in DEBONDING:
        what = f"unknown rule {settings.debonding!r}"
        raise FreerockError("fits.debonding", what, f"use {' or '.join(DEBONDING)}")
    if not law.allows(settings.debonding, len(law.ratios)):
        what = f"the tensionless rule is not available for {' and '.join(law.parameters[1:])} together"
        raise FreerockError("fits.debonding", what, f"use geometric or remove {name} from fits.models")
    if "edge_radius" in settings.free and "edge_radius" not in law.may_free:
        raise FreerockError(key, f"rounded edges are not worked out for {name}", "remove edge_radius")
    if "edge_radius" in settings.free and settings.debonding != GEOMETRIC.debonding:
        what = "rounded edges require the geometric rule"
        raise FreerockError("fits.debonding", what, f"use geometric or remove edge_radius from {key}")
