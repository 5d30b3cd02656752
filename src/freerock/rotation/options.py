"""Options of the step from volts to θ(t)."""

from dataclasses import dataclass


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


DEFAULTS = RotationOptions()
