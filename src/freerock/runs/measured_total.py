"""Total uncertainty of what is measured of a run: release angle, peaks, restitution of each impact.

A moved input changes the angle that a reading means, and so the restitution, which follows from two angles by
the energies of a rigid block. Instants do not matter. The rotation assumes a corner that does not sink. The
effect of a sinking corner counts as a standard uncertainty if the run's tail shows the stiffness of the bed.
"""

import math
from dataclasses import dataclass

import numpy as np

from freerock.arrays import Floats
from freerock.models.laws import Foundation
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.u_total import Contributions
from freerock.rotation.view import view_of
from freerock.runs.impacts import Impacts, energy_of_peaks

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
    u = np.hypot(
        measured_contributions(theta0, impacts, laboratory).total(stderr), sunk(theta0, impacts, laboratory)
    )
    return MeasuredTotal(float(u[0]), *np.split(u[1:], 3))


def sunk(theta0: float, impacts: Impacts, laboratory: Laboratory) -> Floats:
    """By what a corner that sinks puts off the numbers of `measured_contributions`, shape (n_numbers,).

    The bed is that of `Impacts.theta_uplift` (F26). 0 where one beam does not see its corner or the tail does
    not show it; of what is not known of an impact as well.
    """
    angles, block = _angles(theta0, impacts), laboratory.block
    view = view_of(list(laboratory.lasers.values()), block) if laboratory.lasers else None
    if view is None or view.laser.beam is None or not impacts.theta_uplift > 0:
        return np.zeros(len(angles) + len(impacts.time_s))
    bed = Foundation(block.weight / (2 * block.b**2 * math.sin(impacts.theta_uplift)))
    known = np.abs(angles) < block.theta_cr
    turned = angles.copy()
    turned[known] = [view.released(angle, block, bed) for angle in angles[known].tolist()]
    seen, true = (_with_restitution(each, laboratory) for each in (angles, turned))
    return np.nan_to_num(true - seen)


def measured_contributions(theta0: float, impacts: Impacts, laboratory: Laboratory) -> Contributions:
    """What the laboratory's inputs contribute to release angle, peaks and restitutions.

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
    Contributions
        Numbers: θ0 [rad], the peaks before [rad], the peaks after [rad] and the restitutions of all impacts.
    """
    angles, columns = _angles(theta0, impacts), []
    for source in laboratory.inputs:
        others = (laboratory.moved(source, by) for by in (SHARE, -SHARE))
        with np.errstate(invalid="ignore", divide="ignore"):  # a peak may be unknown, or overturned there
            high, low = (_with_restitution(laboratory.reread(angles, other), other) for other in others)
        columns.append((high - low) / (2 * SHARE))
    n_numbers = 1 + 3 * len(impacts.time_s)
    return Contributions.held(laboratory.inputs, np.reshape(columns, (-1, n_numbers)).T)


def _angles(theta0: float, impacts: Impacts) -> Floats:
    return np.concatenate([[theta0], impacts.peak_before_rad, impacts.peak_after_rad])


def _with_restitution(angles: Floats, laboratory: Laboratory) -> Floats:
    """Angles and the restitutions from the peaks among them, as by `impacts.restitution_from_peaks`."""
    block, tilt = laboratory.block, laboratory.tilt
    energy, left = (energy_of_peaks(peaks, block, tilt)[0] for peaks in np.split(angles[1:], 2))
    return np.concatenate([angles, np.sqrt(left / energy)])
