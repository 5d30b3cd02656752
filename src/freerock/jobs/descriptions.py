"""Texts that describe a dataset: they reach a step beside its parameters, since their edits rerun none."""

from collections.abc import Mapping
from typing import Any


def described(settings: Mapping[str, Any], texts: Mapping[str, Any]) -> dict[str, Any]:
    """Settings of a record, their attributes completed by the texts of its campaign.

    Parameters
    ----------
    settings : mapping
        As `freerock.config.step_settings.record_settings` gives them.
    texts : mapping
        By campaign, as `freerock.config.step_settings.descriptions` gives them.

    Returns
    -------
    dict
        The same settings; attributes in the order of ACDD, none of them empty.
    """
    own = settings["attributes"]
    test, told = own["test"], texts[own["campaign"]]
    found = {"title": f"{told['title']}: {test}", "summary": told["summary"], **own}
    found |= {name: told[name] for name in ("institution", "creator_name", "license", "references")}
    found["comment"] = told["comments"].get(test, "")
    return {**settings, "attributes": {name: value for name, value in found.items() if value != ""}}
