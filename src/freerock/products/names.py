"""The one vocabulary of the datasets: each variable with its unit and long name.

Units and long names are in `variables.csv`, the variables of a fit in `netcdf`, the columns of runs.csv and
other tables in `tables.columns`.
"""

import csv
from collections.abc import Container, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from freerock.rotation.flags import FLAGS

ORIGINS = {
    "simulated": "simulated laser record of a free-rocking test",
    "measured": "laser record of a free-rocking test",
}

# Field of Run and of Impacts -> variable of the dataset, whose unit is an attribute.
OF_RUN = ["hold_start_s", "release_s", "release_stderr_s", "fit_start_s", "end_s", "theta0", "theta0_stderr"]
OF_RUN += ["zero_stderr", "sigma_theta", "n_impacts"]
RUN_VARIABLES = {field: field.removesuffix("_s") for field in OF_RUN}

OF_IMPACTS = ["peak_before_rad", "peak_before_stderr_rad", "peak_after_rad", "peak_after_stderr_rad"]
OF_IMPACTS += ["restitution", "restitution_stderr"]
IMPACT_VARIABLES = {"time_s": "impact_time", "time_stderr_s": "impact_time_stderr"}
IMPACT_VARIABLES |= {field: field.removesuffix("_rad") for field in [*OF_IMPACTS, "theta_uplift"]}

WITH_TOTAL = ("peak_before", "peak_after", "restitution")  # of an impact, with a total uncertainty NAME_u

with open(Path(__file__).with_name("variables.csv"), encoding="utf-8", newline="") as file:
    # By name: unit ("" for texts, flags and what has the unit of a parameter; "1" is not written), long name,
    # and what the flags 0 and 1 mean.
    VARIABLES = {row["name"]: row for row in csv.DictReader(file)}
SAMPLE_FLAGS = {
    "standard_name": "quality_flag",
    "flag_masks": np.array(list(FLAGS.values()), np.uint8),
    "flag_meanings": " ".join(FLAGS),
}
BESIDE = {
    "theta": ("sigma_theta", "flags"),
    **{name: (f"{name}_u",) for name in ("theta0", *WITH_TOTAL)},
    "value": ("stderr", "u_law", "u_total", "unit"),
}
DRAWN = {"time", "theta", "theta_model", "residual"}  # along an axis of a plot that xarray labels
SINGLE_PRECISION = {"sigma_theta", *(f"{name}{n}" for name in ("voltage", "current") for n in ("", "_2"))}


def long_name_of(name: str) -> str:
    """What a variable is."""
    error = "standard error of the " if name.endswith("_stderr") else ""
    return error + _row(name)["long_name"]


def describe(name: str, present: Container[object], named: bool = True) -> dict[str, Any]:
    """CF attributes of a variable among those present beside it, with its long name if `named` or drawn."""
    row = _row(name)
    attrs: dict[str, Any] = {"long_name": long_name_of(name)} if named or name in DRAWN else {}
    if row["unit"] not in ("", "1"):
        attrs["units"] = row["unit"]
    beside = [other for other in (f"{name}_stderr", *BESIDE.get(name, ())) if other in present]
    if beside:
        attrs["ancillary_variables"] = " ".join(beside)
    if row["flag_meanings"]:
        attrs |= {"flag_values": np.array([0, 1], np.int8), "flag_meanings": row["flag_meanings"]}
    return attrs | (SAMPLE_FLAGS if name == "flags" else {})


def _row(name: str) -> dict[str, str]:
    return VARIABLES[name.removesuffix("_stderr").removesuffix("_2")]


def root_attributes(product: str, done: str, attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Root attributes of a product."""
    of = [attrs[key] for key in ("campaign", "test") if key in attrs]
    return {
        "Conventions": "CF-1.11, ACDD-1.3",
        "title": ": ".join(of),
        "keywords": "rocking, rigid block, free rocking test, restitution, Housner, Winkler, Hunt-Crossley",
        **attrs,
        "summary": attrs.get("summary") or f"A {ORIGINS[attrs['origin']]}.",
        "id": "/".join([*of, product]),
        "freerock_product": product,
        "source": ORIGINS[attrs["origin"]],
        "history": f"freerock {version('freerock')}: {done}",
    }
