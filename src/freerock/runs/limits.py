"""Thresholds of the steps from θ(t) to impacts."""

import math
from dataclasses import dataclass

SQUAT = math.radians(30)  # from this critical angle on a block may bounce, and then swing higher or longer


@dataclass(frozen=True)
class RunLimits:
    """Thresholds of `segment.find_runs`.

    Parameters
    ----------
    window_s : float
        Window of `still.stationary_phases` [s].
    held_s : float
        θ0 is read over this long before the release [s].
    finger_s : float
        Time the finger takes to leave [s]: no sample is used from as long before the release to as long
        after it. Also the standard error of a release set by hand.
    min_impacts : int
        Fewer impacts are a fail.
    max_flagged_fraction : float
        A larger share of invalid samples from the end of the hold to rest is a fail, a smaller one a warning.
    max_push_fraction : float
        Warning when the motion is that from an angle which differs from θ0 by more than this share, because
        the block was pushed or held back.
    max_hold_drift_deg : float
        Warning when the held angle moves by more than this over `held_s` [degree].
    max_rest_shift_deg : float
        Warning when the rest positions before and after differ by more than this [degree].
    max_growth_fraction : float
        A swing higher than the one before by a larger share, or one that lasts clearly longer, is not free:
        the block was touched, a fail.
    start : str
        "hold" (a run begins with the release from a hold) or "motion" (at the last instant at which anything
        but the ground acted on it, `begun_in_motion`).
    """

    window_s: float = 0.25
    held_s: float = 1.0
    finger_s: float = 0.03
    min_impacts: int = 3
    max_flagged_fraction: float = 0.02
    max_push_fraction: float = 0.02
    max_hold_drift_deg: float = 0.05
    max_rest_shift_deg: float = 0.05
    max_growth_fraction: float = 0.05
    start: str = "hold"


@dataclass(frozen=True)
class ImpactLimits:
    """Thresholds of `impacts.find_impacts`.

    Parameters
    ----------
    min_amplitude_sigmas : float
        Peaks lower than this many σ_θ end the list.
    min_uplift_ratio : float
        Peaks lower than this many times the amplitude under which the base stays in full contact end it too.
    min_samples : int
        Swings with fewer samples end it too.
    """

    min_amplitude_sigmas: float = 10.0
    min_uplift_ratio: float = 2.0
    min_samples: int = 12


OF_RUNS, OF_IMPACTS = RunLimits(), ImpactLimits()
