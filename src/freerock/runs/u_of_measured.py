"""Total standard uncertainty of what is measured of a run, release angle, peaks and r: `measured_total`.

Other modules have `u_total` of parameters (`identification.u_total`, with the `Contributions` of this
module), of r by energy (`populations.impact_energy`), of means (`populations.random_effects`) and of plans
(`planning.bound`).

Of what is measured of a run a moved input changes the angle that a reading means, and so the restitution,
which follows from two angles by the energies of a rigid block. Instants do not matter. The rotation assumes a
corner that does not sink. The effect of a sinking corner counts as a standard uncertainty if the run's tail
shows the stiffness of the bed.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from freerock.arrays import Floats
from freerock.models.laws import Foundation
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.view import view_of
from freerock.runs.impacts import Impacts, energy_of_peaks

OF_LAW = "law"  # label of the model discrepancy in the budget: all fits of one law share it


@dataclass(frozen=True)
class Contributions:
    """What the inputs of a laboratory contribute to the uncertainty of some numbers.

    Parameters
    ----------
    inputs : tuple of Input
    values : ndarray, shape (n_numbers, n_inputs)
        Shift of each number for one standard uncertainty of the stated value of each input, in the unit of
        the number; NaN where it is not known.
    moved : ndarray, shape (n_inputs,)
        By how many of its standard uncertainties a fit moves each input; 0 of a fit that holds them.
    remaining : ndarray, shape (n_inputs,)
        Standard uncertainty of each input after the fit over that before it; 1 of a fit that holds them.
    pulls : ndarray, shape (n_inputs,)
        (ν̂ - ν⁰) over its standard deviation, √(u² - û²) where the noise is white: standard normal where law
        and uncertainties are right (Demortier and Lyons 2002, CDF note 5776). NaN where the run does not see
        the input.
    impacts : ndarray, shape (n_numbers, n_inputs)
        Shift of each number where an input is held one remaining standard uncertainty above where the fit
        has it, and all else is fitted again (Conway 2011, arXiv:1103.0354), in the unit of the number.
    """

    inputs: tuple[Input, ...]
    values: Floats
    moved: Floats
    remaining: Floats
    pulls: Floats
    impacts: Floats

    @property
    def p_of_pulls(self) -> float:
        """Chance of so large a pull of any input, were all uncertainties right (Bonferroni); at most 1."""
        seen = np.abs(self.pulls[~np.isnan(self.pulls)])
        return min(1.0, 2 * len(seen) * float(ndtr(-seen.max(initial=0.0)))) if len(seen) else 1.0


SHARE = 0.1  # of its uncertainty, by which an input is moved to either side


@dataclass(frozen=True)
class MeasuredTotal:
    """Total standard uncertainties of a run's numbers: of noise and inputs together.

    Parameters
    ----------
    theta0 : float
        Of the release angle [rad].
    peak_before, peak_after : ndarray, shape (n_impacts,)
        Of the peaks on either side of each impact [rad].
    restitution : ndarray, shape (n_impacts,)
        Of r from these two peaks. NaN where r is.
    """

    theta0: float
    peak_before: Floats
    peak_after: Floats
    restitution: Floats


def measured_total(
    theta0: float, theta0_stderr: float, impacts: Impacts, laboratory: Laboratory
) -> MeasuredTotal:
    """Total standard uncertainties of release angle and impacts of a run.

    Parameters
    ----------
    theta0, theta0_stderr : float
        Release angle and its standard error [rad].
    impacts : Impacts
        Of the run.
    laboratory : Laboratory
        With whose numbers they were found.
    """
    stderr = np.concatenate(
        [
            [theta0_stderr],
            impacts.peak_before_stderr_rad,
            impacts.peak_after_stderr_rad,
            impacts.restitution_stderr,
        ]
    )
    shifts = measured_contributions(theta0, impacts, laboratory)
    u = np.sqrt(stderr**2 + np.sum(shifts**2, axis=1))
    u = np.hypot(u, sunk(theta0, impacts, laboratory))
    return MeasuredTotal(float(u[0]), *np.split(u[1:], 3))


def sunk(theta0: float, impacts: Impacts, laboratory: Laboratory) -> Floats:
    """By what a corner that sinks puts off the numbers of `measured_contributions`, shape (n_numbers,).

    The bed is that of `Impacts.theta_uplift` (F26). 0 where one beam does not see its corner or the tail does
    not show it; of what is not known of an impact as well.
    """
    angles, block = np.hstack([theta0, impacts.peak_before_rad, impacts.peak_after_rad]), laboratory.block
    view = view_of(list(laboratory.lasers.values()), block) if laboratory.lasers else None
    if view is None or view.laser.beam is None or not impacts.theta_uplift > 0:
        return np.zeros(len(angles) + len(impacts.time_s))
    bed = Foundation(block.weight / (2 * block.b**2 * math.sin(impacts.theta_uplift)))
    known = np.abs(angles) < block.theta_cr
    turned = angles.copy()
    turned[known] = [view.released(angle, block, bed) for angle in angles[known].tolist()]
    seen, true = (_with_restitution(each, laboratory) for each in (angles, turned))
    return np.nan_to_num(true - seen)


def measured_contributions(theta0: float, impacts: Impacts, laboratory: Laboratory) -> Floats:
    """Shifts of release angle, peaks and restitutions for one standard uncertainty of each input.

    Rotation counts from the base, so that a base off level moves no peak. It moves where the block balances:
    leant by β to the right, θ_cr - β on the right and θ_cr + β on the left.

    Parameters
    ----------
    theta0 : float
        Release angle [rad].
    impacts : Impacts
        Of the run.
    laboratory : Laboratory
        With whose numbers they were found.

    Returns
    -------
    ndarray, shape (n_numbers, n_inputs)
        Numbers: θ0 [rad], the peaks before [rad], the peaks after [rad] and the restitutions of all impacts.
    """
    angles, columns = np.hstack([theta0, impacts.peak_before_rad, impacts.peak_after_rad]), []
    for source in laboratory.inputs:
        others = (laboratory.moved({source: by}) for by in (SHARE, -SHARE))
        with np.errstate(invalid="ignore", divide="ignore"):  # a peak may be unknown, or overturned there
            high, low = (_with_restitution(laboratory.reread(angles, other), other) for other in others)
        columns.append((high - low) / (2 * SHARE))
    return np.reshape(columns, (-1, 1 + 3 * len(impacts.time_s))).T


def _with_restitution(angles: Floats, laboratory: Laboratory) -> Floats:
    """Angles and the restitutions from the peaks among them, as by `impacts.restitution_from_peaks`."""
    block, tilt = laboratory.block, laboratory.tilt
    energy, left = (energy_of_peaks(peaks, block, tilt)[0] for peaks in np.split(angles[1:], 2))
    return np.concatenate([angles, np.sqrt(left / energy)])
