"""Settings of the steps, with the defaults of `processing`, of lasers and some of `fits`.

Other defaults stand beside their keys in `keys.py`, `campaign.py` and `laser_section.py`, default
uncertainties in `default_uncertainties.py`. config/README.md lists all of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from freerock.models.free_parameters import PER_RUN
from freerock.models.given import Given
from freerock.models.laws import CANDIDATES


@dataclass(frozen=True, kw_only=True)
class LaserKeys:
    """The keys of a laser that have defaults; `rotation.sensor.Laser` describes them."""

    face: str = "left"
    sign: int = 1
    release_side: str = "positive"
    response_ms: float = 0.0
    response: str = "average"
    volts_at_start: float = 0.0
    volts_at_end: float = 10.0
    valid_low_v: float = -0.1
    valid_high_v: float = 10.1
    error_level_v: float = 10.2
    error_tolerance_v: float = 0.01
    milliamps_at_start: float = 4.0
    milliamps_at_end: float = 20.0
    valid_low_ma: float = 3.84
    valid_high_ma: float = 20.16
    error_level_ma: float = 3.75
    error_tolerance_ma: float = 0.01


@dataclass(frozen=True)
class RotationOptions:
    """Choices and thresholds of `rotation.find_rotation`.

    Parameters
    ----------
    mains_hz : float or None
        Nominal frequency of the mains [Hz]; None leaves their interference in the signal.
    window_s : float
        Window in which a still signal is sought, see `still.stationary_phases` [s].
    max_disagreement_deg : float
        Two lasers disagree where the translation they find would turn the angle of the first alone by more
        than this [degree].
    """

    mains_hz: float | None = 50.0
    window_s: float = 0.25
    max_disagreement_deg: float = 0.5


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


@dataclass(frozen=True)
class FitSettings:
    """How a model is fitted.

    Parameters
    ----------
    free : sequence of str
        Further free parameters: "theta0" and "t0", within six standard errors of their measured values, or
        0.2 % and 1 ms if those are more; "width", the distance between the corners of rotation; "tilt" of
        the base; "edge_radius"; "r_per_impact" of one run of the Housner model: r, r_2,
        r_3 and so on; "release": "theta0" and "t0" may differ from the measured ones by 10 % and 50 ms, as
        after a push or with a slow finger.
    debonding : str
        "geometric" or "tensionless".
    integrator_error : float
        Largest shift of a parameter by the integrator's error, as a share of its standard error.
    profile : bool
        Whether the intervals of the model's parameters are those of the profile likelihood.
    parameters : mapping of str to mapping of str to Given or mapping
        Options of each parameter, by law, in lmfit's words: value, min, max, vary, expr.
    """

    free: Sequence[str] = PER_RUN
    debonding: str = "geometric"
    integrator_error: float = 0.2
    profile: bool = False
    parameters: Mapping[str, Mapping[str, Given | Mapping[str, Any]]] = field(
        default_factory=dict, hash=False
    )

    @property
    def loose_release(self) -> bool:
        """Whether the release may leave what was measured."""
        return "release" in self.free

    def given(self, model: str) -> dict[str, Given]:
        """What is said beforehand of the parameters of a candidate's law, by name."""
        own = self.parameters.get(CANDIDATES[model].law, {})
        return {name: each if isinstance(each, Given) else Given(**each) for name, each in own.items()}


ROTATION, RUNS, IMPACTS, FITS = RotationOptions(), RunLimits(), ImpactLimits(), FitSettings()
