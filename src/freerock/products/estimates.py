"""Plain values of fit datasets: estimates for predictions, evidence for the choice."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.given import legal
from freerock.models.laws import MODELS
from freerock.populations.estimate import Estimate
from freerock.products.contents import fits_of
from freerock.rotation.laboratory import Input

if TYPE_CHECKING:
    import lmfit


def estimates_in(trees: Iterable[xr.DataTree]) -> Iterator[Estimate]:
    """The fits of records that may be used, in order.

    Parameters
    ----------
    trees : iterable of xarray.DataTree
        Roots of `fits/<test>.nc`; samples are not needed.
    """
    for tree in trees:
        names = {key: str(tree.attrs[key]) for key in ("campaign", "test", "block", "foundation")}
        for run, model, fit, inputs in fits_of(tree):
            if not fit.attrs["success"]:
                continue
            freed = fit["parameter"].values.astype(str)
            n = len(MODELS[model])
            yield Estimate(
                **names,
                run=run,
                model=model,
                values=dict(zip(freed.tolist(), fit["value"].values, strict=True)),
                covariance=fit["covariance"].values[:n, :n],
                shifts=_shifts(inputs, fit["value"].values[:n]),
                moved=_moved(inputs),
                sigma_r=fit["sigma_r"].item(),
            )


def parameters_in(fit: xr.Dataset) -> "lmfit.Parameters":
    """Parameters of a fit as lmfit has them: value, standard error, bounds, ties, correlations.

    Parameters
    ----------
    fit : xarray.Dataset
        A model of a run: `open_fits(path)["run_1/winkler"]`.

    Examples
    --------
    >>> fits = freerock.open_fits("results/palermo_virtual/fits/config2_marble.nc")  # doctest: +SKIP
    >>> k = freerock.parameters_in(fits["run_1/hunt_crossley"].dataset)["k"]  # doctest: +SKIP
    >>> print(f"{k.value:.1e} ± {k.stderr:.0e}, from {k.min:.0e} to {k.max:.0e}")  # doctest: +SKIP
    6.9e+06 ± 2e+04, from 1e+04 to 1e+11
    """
    import lmfit

    if "parameter" not in fit:
        raise FreerockError("fit", "the group has no parameters", "give that of a model: run_1/winkler")
    names = fit["parameter"].values.astype(str).tolist()
    found, stderr = lmfit.Parameters(), np.sqrt(np.diag(fit["covariance"].values))
    columns = (fit[name].values.tolist() for name in ("value", "vary", "min", "max", "expr"))
    for name, value, vary, low, high, expr in zip(names, *columns, strict=True):
        found.add(legal(name), value, bool(vary), low, high, expr or None)
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = fit["covariance"].values / np.outer(stderr, stderr)
    free = [i for i, name in enumerate(names) if found[legal(name)].vary]
    for i in free:
        own = found[legal(names[i])]
        own.stderr = float(stderr[i])
        own.correl = {legal(names[j]): float(correlation[i, j]) for j in free if j != i} or None
    return found


def _shifts(inputs: xr.Dataset, values: Floats) -> dict[tuple[str, str], Floats]:
    """Relative shifts of the first parameters, which have these values, by owner and name of the inputs."""
    if "contribution" not in inputs:
        return {}
    relative = inputs["contribution"].values[: len(values)] / values[:, None]
    names = zip(inputs["input_owner"].values.tolist(), inputs["input"].values.tolist(), strict=True)
    return dict(zip(names, relative.T, strict=True))


def _moved(inputs: xr.Dataset) -> dict[Input, float]:
    """By how many of its standard uncertainties the fit moved each input, of those that it moved."""
    if "input_moved" not in inputs:
        return {}
    columns = (inputs[name].values.tolist() for name in ("input_owner", "input", "input_u", "input_moved"))
    return {Input(owner, name, u, True): by for owner, name, u, by in zip(*columns, strict=True) if by}
