"""The misfit map: how far ε_θ rises around the two parameters that were identified on a run."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from freerock.arrays import Floats
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, MODELS
from freerock.models.simulate import Solver
from freerock.rotation.as_measured import as_measured
from freerock.rotation.view import View


@dataclass(frozen=True)
class MapGrid:
    """Of a misfit map.

    Parameters
    ----------
    span : float
        Of the parameters around the identified ones, in logarithms.
    cells : int
        Each way.
    finer : int
        Points each way of the finer grid, between whose cells θ(t) is interpolated.
    samples : int
        Most of a run.
    rtol : float
        Of the integrator.
    """

    span: float = 0.3
    cells: int = 25
    finer: int = 4 * 25 - 3
    samples: int = 1000
    rtol: float = 1e-4


GRID = MapGrid()


def misfit_map(
    model: str,
    block: Block,
    values: Mapping[str, float],
    time_s: Floats,
    theta: Floats,
    debonding: str = "geometric",
    view: View | None = None,
) -> xr.Dataset:
    """ε_θ around the identified parameters of a law with two parameters, on a grid and on a finer one.

    Angle and instant of release, and the width, stay as they were identified.

    Parameters
    ----------
    model : str
        Of two parameters: "winkler" or "hunt_crossley", or a rival of theirs.
    block : Block
    values : mapping of str to float
        What the fit found, nuisances included [SI].
    time_s, theta : ndarray, shape (n_time,)
        Time since the release [s] and measured rotation [rad].
    debonding : str
        "geometric" or "tensionless".
    view : View, optional
        What the sensor makes of a motion.

    Returns
    -------
    xarray.Dataset
        epsilon_theta, ε_θ as a fraction, a row per value of the second parameter, a column per value of the
        first; epsilon_finer, for contours, on the finer grid, with θ(t) interpolated between the cells of the
        grid: the map's trough may be narrower than a cell. Coordinates, of names such as k and lambda: the
        values of both along the sides of the grid [SI], and along those of the finer one, NAME_finer.
    """
    candidate, (x, y) = CANDIDATES[model], MODELS[model]
    rules = candidate.rules(debonding)
    every = max(1, len(time_s) // GRID.samples)
    time_s, theta = time_s[::every], theta[::every]
    known = {"theta0": theta[0], **values}
    share = np.exp(np.linspace(-GRID.span, GRID.span, GRID.cells))
    first, second = values[x] * share, values[y] * share
    theta_model = np.empty((GRID.cells, GRID.cells, len(time_s)))
    for row, of_second in enumerate(second):
        for column, of_first in enumerate(first):
            at = known | {x: of_first, y: of_second}
            theta_model[row, column] = as_measured(
                candidate.law, block, at, time_s, view, rules=rules, solver=Solver(GRID.rtol)
            )
    epsilon = np.array([[epsilon_theta(time_s, each, theta) for each in row] for row in theta_model])
    finer = np.exp(np.linspace(-GRID.span, GRID.span, GRID.finer))
    return xr.Dataset(
        {
            "epsilon_theta": ((y, x), epsilon),
            "epsilon_finer": ((f"{y}_finer", f"{x}_finer"), between_cells(time_s, theta_model, theta)),
        },
        {x: first, y: second, f"{x}_finer": values[x] * finer, f"{y}_finer": values[y] * finer},
    )


def between_cells(time_s: Floats, theta_model: Floats, theta: Floats) -> Floats:
    """ε_θ on the finer grid, shape (n_finer, n_finer), with θ(t) interpolated between the cells.

    Parameters
    ----------
    time_s, theta : ndarray, shape (n_time,)
        Time [s] and measured rotation [rad].
    theta_model : ndarray, shape (n_cells, n_cells, n_time)
        Modelled rotation of each cell [rad].
    """
    step = np.gradient(time_s)
    weight = np.sqrt(step / (step @ np.nan_to_num(theta) ** 2))
    residual = np.nan_to_num(theta_model - theta) * weight
    spline = CubicSpline(np.arange(GRID.cells), np.eye(GRID.cells))
    between = spline(np.linspace(0, GRID.cells - 1, GRID.finer))
    rows = (between @ np.tensordot(row, residual, 1) for row in between)
    return np.array([(row**2).sum(axis=1) for row in rows])
