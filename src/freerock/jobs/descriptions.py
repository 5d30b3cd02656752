"""The texts that describe datasets, given to the steps that make them without being parameters of these."""

from collections.abc import Mapping
from typing import Any


def described(records: Mapping[str, Any], descriptions: Mapping[str, Any]) -> dict[str, Any]:
    """Settings of records, their attributes completed by the texts of their campaigns.

    Parameters
    ----------
    records : mapping
        Settings by test, as `freerock.config.step_settings.record_settings` gives them.
    descriptions : mapping
        Texts by campaign, as `freerock.config.step_settings.descriptions` gives them.

    Returns
    -------
    dict
        The same settings; attributes in the order of ACDD, none of them empty.
    """
    return {
        test: {**own, "attributes": _complete(own["attributes"], descriptions[own["attributes"]["campaign"]])}
        for test, own in records.items()
    }


def _complete(attributes: Mapping[str, Any], texts: Mapping[str, Any]) -> dict[str, Any]:
    test = attributes["test"]
    found = {"title": f"{texts['title']}: {test}", "summary": texts["summary"], **attributes}
    found |= {name: texts[name] for name in ("institution", "creator_name", "license", "references")}
    found["comment"] = texts["comments"].get(test, "")
    return {name: value for name, value in found.items() if value != ""}
