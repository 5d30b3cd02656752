"""The steps from volts to impacts: the keys of `processing`."""

from typing import Literal

from freerock.config.values import NotNegative, Number, Positive, Section, Whole, key


class RotationOptions(Section):
    """Settings of the step from volts to θ(t).

    The choices and thresholds of `rotation.find_rotation`.

    Parameters
    ----------
    mains_hz : float or None
        Nominal frequency of the mains [Hz]; None leaves their interference in the signal.
    window_s : float
        Window in which a still signal is sought, see `still_phases.stationary_phases` [s].
    max_disagreement_deg : float
        Two lasers disagree where the translation they find would turn the angle of the first alone by more
        than this [degree].
    time_unit : str
        Unit of time stamps in record files that state none.
    sampling_rate_hz : float or None
        Sampling rate of record files that state none [Hz].
    """

    mains_hz: Positive | None = key("the mains frequency in hertz, subtracted; empty to keep it", 50.0)
    window_s: Positive = key("the window in which a still signal is sought, in seconds", 0.25)
    max_disagreement_deg: Positive = key(
        "the largest difference between two lasers without a warning, in degrees", 0.5
    )
    time_unit: Literal["", "s", "ms", "us", "min"] = key(
        "the unit of time (s, ms, us, min) where the record files state none", ""
    )
    sampling_rate_hz: Positive | None = key(
        "the sampling rate in hertz where the record files state none", None
    )


class RunLimits(Section):
    """Settings of the step from θ(t) to free-rocking runs.

    The thresholds of `runs.find_runs`.

    Parameters
    ----------
    window_s : float
        Window of `still_phases.stationary_phases` [s].
    held_s : float
        θ0 is read over this long before the release [s].
    finger_s : float
        Time the finger takes to leave [s]: no sample is used from as long before the release to as long
        after it. Also the standard error of a release set by hand.
    min_impacts : int
        Fewer zero crossings of θ are a fail.
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
    """

    window_s: Positive = key("the window in which a still block is sought, in seconds", 0.25)
    held_s: Positive = key("how long before the release θ0 is read, in seconds", 1.0)
    finger_s: NotNegative = key("how long the finger takes to leave, in seconds; not fitted", 0.03)
    min_impacts: Whole = key("the least number of zero crossings of θ; with fewer the run fails", 3, ge=0)
    max_flagged_fraction: Number = key(
        "the largest share of invalid samples; above it the run fails", 0.02, ge=0, le=1
    )
    max_push_fraction: NotNegative = key("the largest push without a warning, as a share of θ0", 0.02)
    max_hold_drift_deg: NotNegative = key("the largest creep of a hold without a warning, in degrees", 0.05)
    max_rest_shift_deg: NotNegative = key("the largest shift of the rest without a warning, in degrees", 0.05)
    max_growth_fraction: NotNegative = key(
        "the largest growth from swing to swing, as a share; above it the run fails", 0.05
    )


class ImpactLimits(Section):
    """Settings of the step from a run to its impacts and restitution coefficients.

    The thresholds of `impacts.find_impacts`.

    Parameters
    ----------
    min_amplitude_sigmas : float
        Peaks lower than this many σ_θ end the list.
    min_uplift_ratio : float
        Peaks lower than this many times the amplitude under which the base stays in full contact end it too.
    min_samples : int
        Swings with fewer samples end it too.
    """

    min_amplitude_sigmas: Positive = key("the lowest peak that is used, as a multiple of σ_θ", 10.0)
    min_uplift_ratio: Number = key("the lowest peak that is used, over the uplift amplitude", 2.0, ge=1)
    min_samples: Whole = key("the fewest samples of a swing that is used", 12, ge=3)


ROTATION_OPTIONS, RUN_LIMITS, IMPACT_LIMITS = RotationOptions(), RunLimits(), ImpactLimits()


class ProcessingSection(Section):
    """The steps from volts to impacts."""

    rotation: RotationOptions = key("volts to θ(t)", ROTATION_OPTIONS)
    runs: RunLimits = key("θ(t) to free-rocking runs", RUN_LIMITS)
    impacts: ImpactLimits = key("runs to impacts and restitution", IMPACT_LIMITS)
