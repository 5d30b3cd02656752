"""Types of values of keys (numbers, names, choices), and `Section`, a group of keys."""

import re
from collections.abc import Collection, Iterable, Mapping
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StringConstraints,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

from freerock.models.laws import CANDIDATES, DEBONDING, KINEMATICS, LAWS, MODELS
from freerock.units import CHANNEL_UNITS

LEAST_SI, MOST_SI = 1e-12, 1e15  # of numbers except 0
LONGEST_NAME = 100  # characters: it becomes part of a file name
Key = tuple[str, ...]  # where a value stands: the keys and list positions on the way to it
NAME_PATTERN = rf"^[A-Za-z0-9_]{{1,{LONGEST_NAME}}}$"


class Invalid(ValueError):
    """What a validator found, with its remedy."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(what)
        self.what, self.remedy = what, remedy


def _as_number(value: Any, parsed: ValidatorFunctionWrapHandler) -> Any:
    """A number as pydantic parses it, less those that no quantity has."""
    if isinstance(value, bool):  # pydantic would read true as 1
        raise Invalid(f"{str(value).lower()} is not a number", "give a number")
    number = parsed(value)
    if number and not LEAST_SI <= abs(number) <= MOST_SI:
        raise Invalid(f"{number:.6g} is out of range", f"give 0, or {LEAST_SI:g} to {MOST_SI:g}")
    return number


def _in_one_line(value: Any) -> Any:
    return " ".join(value.split()) if isinstance(value, str) else value


Number = Annotated[float, WrapValidator(_as_number)]
Whole = Annotated[int, WrapValidator(_as_number)]
Direction = Annotated[Literal[1, -1], WrapValidator(_as_number)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Length = Annotated[Number, Field(gt=0, le=100)]  # of a block or above its base [m]
Place = Annotated[Number, Field(ge=-100, le=100)]  # right of its middle, or of a beam [m]
Name = Annotated[str, StringConstraints(pattern=NAME_PATTERN)]
Label = Annotated[str, BeforeValidator(_in_one_line), Field(max_length=100)]
Text = Annotated[str, BeforeValidator(_in_one_line), Field(max_length=2000)]
if TYPE_CHECKING:  # words known only at run time
    Unit: TypeAlias = str
    Model: TypeAlias = str
    Candidate: TypeAlias = str
    Debonding: TypeAlias = str
    Kinematics: TypeAlias = str
else:
    Unit = Literal["", *CHANNEL_UNITS]
    Model = Literal[*LAWS]
    Candidate = Literal[*CANDIDATES]
    Debonding = Literal[*DEBONDING]
    Kinematics = Literal[*KINEMATICS]


def key(meaning: str, default: Any = ..., **bounds: Any) -> Any:
    """A key of a section: what its value is, its default where it is not compulsory, pydantic's bounds."""
    return Field(default, description=meaning, **bounds)


class Section(BaseModel):
    """A group of keys: unknown keys are refused, nothing changes after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, str_strip_whitespace=True)


def name_fault(name: str) -> tuple[str, str] | None:
    """Why a text can't be a name, and what to do."""
    if not re.fullmatch(NAME_PATTERN, name):
        return f"{shown(name)} is not a name", f"use letters, digits and _ only, at most {LONGEST_NAME}"
    return None


def shown(value: object) -> str:
    """A value as a message shows it."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:50]}…{text[-1]}"


def section_in(annotation: Any) -> type[Section] | None:
    """The section that an annotation names, itself or within a dict, a tuple or an alternative."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return annotation
    return next(filter(None, map(section_in, get_args(annotation))), None)


def closest(word: object, words: Iterable[object]) -> list[str]:
    """The one of some words that a misspelt word may mean, or none."""
    import difflib  # only mistakes have need of it

    return difflib.get_close_matches(str(word), map(str, words), n=1)


def did_you_mean(word: object, words: Iterable[object]) -> str:
    """The question whether the closest of some words was meant; empty when none is close."""
    return "".join(f"did you mean {close!r}?" for close in closest(word, words))


def check_names(names: Iterable[str], known: Collection[str], kind: str) -> None:
    """Refuse the first name that is not among those known; `kind` says what it should be."""
    for name in names:
        if name not in known:
            remedy = did_you_mean(name, known) or f"use one of {', '.join(known)}"
            raise Invalid(f"{name!r} is not {kind}", remedy)


def check_inside(file: str) -> str:
    """The path of a file in the raw folder, without detours; one outside or without a name is refused."""
    if file.startswith("/") or ".." in PurePosixPath(file).parts or re.search(r"[\\:\x00-\x1f]", file):
        remedy = "give a path below it, with / between folders"
        raise Invalid(f"{file!r} is not inside the raw folder", remedy)
    return PurePosixPath(check_braces(file)).as_posix()


def check_braces(path: str) -> str:
    """Refuse the path of a file or folder that Snakemake would take for a pattern."""
    if re.search("[{}]", path):
        raise Invalid(f"{path!r} has braces, which Snakemake takes for wildcards", "rename it")
    return path


def _once(names: Any) -> Any:
    for name in names:
        if names.count(name) > 1:
            raise Invalid(f"{name} is given twice", "keep one")
    return names


Once, OneOrMore = AfterValidator(_once), Field(min_length=1)  # of lists
Folder = Annotated[str, AfterValidator(check_braces)]
Inside = Annotated[str, Field(min_length=1, max_length=1000), AfterValidator(check_inside)]  # the raw folder


def check_parameters(model: str, parameters: Mapping[str, float], on: str = "", width: bool = False) -> None:
    """Refuse parameters that are not exactly those of a model; `on` names the foundation in the message.

    With `width`, width_fraction is among them.
    """
    names = (*MODELS[model], *(["width_fraction"] if width else []))
    check_names(parameters, names, f"a parameter of {model}")
    for name in names:
        if name not in parameters:
            raise Invalid(f"{model}{on} has no {name}", f"give {name} or leave {model} out")
    if parameters.get("r", 0) > 1:
        raise Invalid(f"r = {parameters['r']:g}{on} is above 1", "give r up to 1")
