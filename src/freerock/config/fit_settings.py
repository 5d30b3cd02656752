"""How a model is fitted: defaults of those keys of `fits` that each fit takes, for Python too."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from freerock.models.free_parameters import PER_RUN
from freerock.models.given import Given
from freerock.models.laws import CANDIDATES


@dataclass(frozen=True)
class FitSettings:
    """How a model is fitted.

    Parameters
    ----------
    free : sequence of str
        Further free parameters: "theta0" and "t0", with the uncertainty of their measurement; "width", the
        distance between the corners of rotation; "tilt" of the base; "edge_radius"; "release": "theta0" and
        "t0" may differ from the measured ones by 10 % and 50 ms, as after a push or with a slow finger.
    debonding : str
        "geometric" or "tensionless".
    parameters : mapping of str to mapping of str to Given or mapping
        Options of each parameter, by law, in lmfit's words: value, min, max, vary, expr.
    """

    free: Sequence[str] = PER_RUN
    debonding: str = "geometric"
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


FIT_SETTINGS = FitSettings()
