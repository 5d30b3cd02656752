"""The keys of `published`, with their defaults."""

from typing import Any

from pydantic import field_validator

from freerock.config.values import Model, Name, Number, Section, check_names, key
from freerock.models.laws import MODELS


class PublishedSection(Section):
    """Values of a publication, printed beside the identified ones."""

    doi: str = key("the DOI of the publication, as 10.…/…", pattern=r"^10\.\d{4,9}/\S+$", max_length=200)
    values: dict[Name, dict[Name, dict[Model, dict[str, Number]]]] = key(
        "block: foundation: model: parameter: value, in SI units; epsilon_theta as a fraction counts as a "
        "parameter"
    )
    longest: dict[Name, Name] = key("block: the foundation on which it rocks longest in the publication", {})

    @field_validator("values")
    @classmethod
    def _known_parameters(cls, values: Any) -> Any:
        for foundations in values.values():
            for models in foundations.values():
                for model, parameters in models.items():
                    check_names(parameters, (*MODELS[model], "epsilon_theta"), f"a parameter of {model}")
        return values
