"""Plain values of fit datasets: estimates for predictions and misfit maps, evidence for the choice."""

from collections.abc import Iterable, Iterator

import xarray as xr

from freerock.identification.choice import RESIDUAL, Evidence
from freerock.identification.estimate import Estimate
from freerock.models.laws import MODELS
from freerock.products.groups import fits_of


def estimates_in(tree: xr.DataTree) -> Iterator[Estimate]:
    """The fits of a record that may be used: of each run in order, then the joint ones (run "pooled").

    Parameters
    ----------
    tree : xarray.DataTree
        Root of `fits/<test>.nc`; samples are not needed.
    """
    names = {key: str(tree.attrs[key]) for key in ("campaign", "test", "block", "foundation")}
    for run, model, fit in fits_of(tree):
        if not fit["success"].item():
            continue
        freed = fit["parameter"].values.astype(str)
        n = len(MODELS[model])
        yield Estimate(
            **names,
            run=run,
            model=model,
            values=dict(zip(freed.tolist(), fit["value"].values, strict=True)),
            covariance=fit["covariance"].values[:n, :n],
        )


def evidence_in(tree: xr.DataTree) -> dict[int | str, list[Evidence]]:
    """What is known of each fit of a record, by run; "pooled" for the joint ones.

    Parameters
    ----------
    tree : xarray.DataTree
        Root of `fits/<test>.nc`; samples are not needed.
    """
    found: dict[int | str, list[Evidence]] = {}
    for run, model, fit in fits_of(tree):
        numbers = {
            name: fit[name].item() for name in ("epsilon_theta", "epsilon_holdout", "bic") if name in fit
        }
        numbers |= {name: float(fit.attrs[name]) for name in RESIDUAL if name in fit.attrs}
        found.setdefault(run, []).append(
            Evidence(
                model=model,
                n_freed=int(fit["n_parameters"].item()),
                success=bool(fit["success"].item()),
                message=str(fit.attrs["message"]),
                **numbers,
            )
        )
    return found


def estimates_of(trees: Iterable[xr.DataTree]) -> list[Estimate]:
    """The usable fits of several records, in their order."""
    return [estimate for tree in trees for estimate in estimates_in(tree)]
