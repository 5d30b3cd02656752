"""How models are fitted: `FitSettings`, which each fit takes, and the keys of `fits`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from pydantic import create_model, field_validator

from freerock.config.values import Debonding, Invalid, Kinematics, Model, Number, Once, Section, key
from freerock.models.free_parameters import PER_RUN
from freerock.models.given import Given, faults
from freerock.models.laws import CANDIDATES, KINEMATICS, LAWS, Law


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

    def given(self, model: str) -> dict[str, Given]:
        """What is said beforehand of the parameters of a candidate's law, by name."""
        own = self.parameters.get(CANDIDATES[model].law, {})
        return {name: each if isinstance(each, Given) else Given(**each) for name, each in own.items()}


FIT_SETTINGS = FitSettings()


def _free_field(law: Law) -> tuple[Any, Any]:
    """Type and default of the key that says what is freed of one law."""
    names: Any = Literal.__getitem__(law.may_free)  # type checkers want words written out
    return Annotated[tuple[names, ...], Once], key(f"{', '.join(law.may_free)} or none", law.free)


_FREE_FIELDS: dict[str, Any] = {model: _free_field(law) for model, law in LAWS.items()}
FreeSection = create_model(
    "FreeSection", __base__=Section, __doc__="Further free parameters of each model.", **_FREE_FIELDS
)


class GivenSection(Section):
    """Options of a parameter, in lmfit's words and SI units."""

    value: Number | None = key("its value if vary is false; otherwise an additional start value", None)
    min: Number | None = key("its lower bound", None)
    max: Number | None = key("its upper bound", None)
    vary: bool = key("false to fix it at its value", True)
    expr: str = key("an expression that ties it to other parameters of the law, as 18.9*k", "")


class FitsSection(Section):
    """Identification of the models."""

    models: tuple[Model, ...] = key(
        "the laws to fit: "
        + "; ".join(f"{model} ({law.note})" for model, law in LAWS.items())
        + ". Fitted only if the residuals of the others exceed the noise: "
        + ", ".join(model for model, law in LAWS.items() if law.cases),
        tuple(LAWS),
        min_length=1,
    )
    kinematics: Annotated[tuple[Kinematics, ...], Once] = key(
        "the kinematics of rivals: guided (centre of the base held, as in the paper) or pivoting (about the "
        "lower corner)",
        KINEMATICS,
        min_length=1,
    )
    free: FreeSection = key("further free parameters, law by law", FreeSection())
    parameters: dict[Model, dict[str, GivenSection]] = key(
        "law: parameter: its bounds, its start, its fixed value, or its tie", {}
    )
    paper_mode: bool = key(
        "true to free only the parameters of the laws and fit no rivals, as in Spanos et al. 2017", False
    )
    debonding: Debonding = key(
        "geometric (contact wherever the base is below the ground) or tensionless (only where the foundation"
        " also pushes)",
        FIT_SETTINGS.debonding,
    )

    @field_validator("parameters")
    @classmethod
    def _sound(cls, parameters: Any) -> Any:
        for law, own in parameters.items():
            given = {name: Given(**section.model_dump()) for name, section in own.items()}
            for name, what, remedy in faults(law, given):
                raise Invalid(f"{law}.{name} {what}", remedy)
        return parameters

    @property
    def freed(self) -> dict[str, tuple[str, ...]]:
        """What else is freed, law by law."""
        return {model: () if self.paper_mode else free for model, free in self.free}

    @property
    def given(self) -> dict[str, dict[str, dict[str, Any]]]:
        """What is given of parameters before the fits, by law and parameter."""
        return {
            law: {name: section.model_dump(exclude_defaults=True) for name, section in own.items()}
            for law, own in self.parameters.items()
        }

    @property
    def rivals(self) -> tuple[str, ...]:
        """Kinematics that rivals of the paper's models may take; none where there are no rivals."""
        return () if self.paper_mode else self.kinematics
