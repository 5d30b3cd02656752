"""How well one run can tell the parameters of a law: by its noise alone, and with inputs that are uncertain.

With J the derivatives of the samples by the fitted numbers and σ their white noise, no unbiased estimate has
a covariance below (JᵀJ)⁻¹σ² (Cramér–Rao; Rao 1945, doi:10.1007/978-1-4612-0919-5_16). The inputs ν of the
laboratory are further numbers, each with a prior of its standard uncertainty: their derivatives and the
priors join J, and the block of the parameters is the total covariance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from freerock.arrays import Floats
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import CANDIDATES, MODELS, Rules
from freerock.models.simulate import Solver
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.view import as_measured, view_of

STEP_OF_INPUT = 0.01  # standard uncertainties to either side
LEAST = 1e-7  # smallest over largest singular value, below which the samples do not tell all numbers


@dataclass(frozen=True)
class ExpectedRun:
    """A run as it will be measured, before any noise.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    values : mapping of str to float
        Its parameters [SI], theta0 [rad] and, where it frees it, the contact width [m].
    laboratory : Laboratory
    free : sequence of str
        What is fitted besides the parameters: "theta0", "t0", "width", "tilt", "edge_radius".
    debonding : str
        "geometric" or "tensionless".
    """

    model: str
    values: Mapping[str, float]
    laboratory: Laboratory
    free: Sequence[str]
    debonding: str = "geometric"

    @property
    def names(self) -> tuple[str, ...]:
        """The fitted numbers."""
        return (*MODELS[self.model], *self.free)

    @property
    def inputs(self) -> tuple[Input, ...]:
        """Inputs of the laboratory that are uncertain and that no fitted number takes the place of."""
        freed = {"levelled_deg": "tilt", "com_offset_m": "tilt", "contact_width_m": "width"}
        return tuple(
            each for each in self.laboratory.inputs if each.u > 0 and freed.get(each.name) not in self.free
        )

    def derivatives(self, time_s: Floats) -> tuple[Floats, Floats]:
        """Derivatives of the rotation [rad] by the fitted numbers and by the inputs.

        Parameters
        ----------
        time_s : ndarray, shape (n_time,)
            Instants of the samples since the release [s].

        Returns
        -------
        by_numbers : ndarray, shape (n_time, n_names)
            By each number, in its SI unit.
        by_inputs : ndarray, shape (n_time, n_inputs)
            By each input, in its standard uncertainties.
        """
        start = {"width": 2 * self.laboratory.block.b, "tilt": 0.0, "t0": 0.0}
        start = {**start, "edge_radius": PARAMETERS["edge_radius"].trace, **self.values}

        def by_number(name: str) -> Floats:
            row = PARAMETERS[name]
            step = abs(row.step) * (1.0 if row.fitted_as == "value" else start[name])
            above, below = (self._seen(time_s, start | {name: start[name] + by}) for by in (step, -step))
            return (above - below) / (2 * step)

        def by_input(source: Input) -> Floats:
            # what the response of a sensor does grows with its square, so that its derivative at 0 is none
            low, high = (0.0, 1.0) if source.name == "response_ms" else (-STEP_OF_INPUT, STEP_OF_INPUT)
            below, above = (
                self._seen(time_s, start, self.laboratory.moved({source: by})) for by in (low, high)
            )
            return (above - below) / (high - low)

        by_numbers = np.column_stack([by_number(name) for name in self.names])
        return by_numbers, np.reshape([by_input(each) for each in self.inputs], (-1, len(time_s))).T

    def _seen(self, time_s: Floats, values: Mapping[str, float], moved: Laboratory | None = None) -> Floats:
        """The rotation as the laboratory reads it where its inputs are in truth those of another one."""
        stated, true = self.laboratory, moved or self.laboratory
        candidate = CANDIDATES[self.model]
        used = {name: values[name] for name in (*self.names, "theta0", "t0")}
        used |= {"tilt": values["tilt"] + true.tilt} if true.tilt else {}
        used["theta0"] = float(stated.reread(np.array([used["theta0"]]), true)[0])
        theta = as_measured(
            candidate.law,
            true.block,
            used,
            time_s * true.clock / stated.clock,
            view_of(list(true.lasers.values()), true.block),
            rules=Rules(self.debonding, candidate.kinematics),
            solver=Solver(1e-10),
        )
        return true.reread(theta, stated)


def information_bound(by_numbers: Floats, by_inputs: Floats, sigma_theta: float) -> Floats:
    """Smallest covariance of numbers and inputs; NaN where the samples do not tell all numbers.

    Parameters
    ----------
    by_numbers, by_inputs : ndarray, shapes (n_time, n_numbers) and (n_time, n_inputs)
        From `ExpectedRun.derivatives`; without inputs this is the Cramér–Rao bound.
    sigma_theta : float
        Standard deviation of the white noise of one sample [rad].

    Returns
    -------
    ndarray, shape (n_numbers + n_inputs, n_numbers + n_inputs)
        In the units of the numbers, and in standard uncertainties of the inputs.
    """
    n_inputs = by_inputs.shape[1]
    priors = np.eye(n_inputs, by_numbers.shape[1] + n_inputs, by_numbers.shape[1])
    rows = np.vstack([np.hstack([by_numbers, by_inputs]) / sigma_theta, priors])
    scale = np.linalg.norm(rows, axis=0)
    unknown = np.full((len(scale), len(scale)), np.nan)
    if len(by_numbers) <= by_numbers.shape[1] or not np.all(scale > 0):
        return unknown
    _, size, directions = np.linalg.svd(rows / scale, full_matrices=False)
    inverse = directions.T / size / scale[:, None]
    return inverse @ inverse.T if size[-1] > LEAST * size[0] else unknown
