"""The one vocabulary of the datasets: each variable with its unit, content and long name."""

from collections.abc import Container, Mapping
from importlib.metadata import version
from typing import Any

import numpy as np

from freerock.rotation.flags import FLAGS

ORIGINS = {
    "simulated": "simulated laser record of a free-rocking test",
    "measured": "laser record of a free-rocking test",
}

# Field of Run and of Impacts -> variable of the dataset.
RUN = {
    "hold_start_s": "hold_start",
    "release_s": "release",
    "release_stderr_s": "release_stderr",
    "fit_start_s": "fit_start",
    "end_s": "end",
    "theta0": "theta0",
    "theta0_stderr": "theta0_stderr",
    "zero_stderr": "zero_stderr",
    "sigma_theta": "sigma_theta",
    "n_impacts": "n_impacts",
}

IMPACTS = {
    "time_s": "impact_time",
    "time_stderr_s": "impact_time_stderr",
    "peak_before_rad": "peak_before",
    "peak_before_stderr_rad": "peak_before_stderr",
    "peak_after_rad": "peak_after",
    "peak_after_stderr_rad": "peak_after_stderr",
    "restitution": "restitution",
    "restitution_stderr": "restitution_stderr",
    "restitution_rate": "restitution_rate",
    "restitution_rate_stderr": "restitution_rate_stderr",
    "theta_uplift": "theta_uplift",
}

WITH_TOTAL = ("peak_before", "peak_after", "restitution")  # of an impact, with a total uncertainty NAME_u

# Variable -> unit ("" for texts, flags and what has the unit of a parameter), content, long name.
VARIABLES = {
    "time": ("s", "coordinate", "time"),
    "theta": ("rad", "measured", "rotation of the block, positive clockwise"),
    "sigma_theta": ("rad", "quality", "standard deviation of the noise of theta"),
    "flags": ("", "quality", "validity of the laser sample"),
    "voltage": ("V", "measured", "output voltage of the laser"),
    "current": ("mA", "measured", "output current of the laser"),
    "displacement": ("m", "measured", "displacement as recorded"),
    "rotation": ("rad", "measured", "rotation as recorded"),
    "translation": ("m", "measured", "translation of the block along the beams, away from the sensors"),
    "position_x": ("m", "measured", "position of the centre of the block, to the right"),
    "position_z": ("m", "measured", "position of the centre of the block, upward"),
    "fault": ("", "quality", "fault of the signal"),
    "fault_start": ("s", "quality", "start of the fault"),
    "fault_end": ("s", "quality", "end of the fault"),
    "fault_note": ("", "quality", "details of the fault"),
    "fault_angle": ("rad", "quality", "effect of the fault on theta"),
    "hold_start": ("s", "measured", "start of the held phase before the release"),
    "release": ("s", "measured", "instant of release"),
    "fit_start": ("s", "measured", "first instant used in a fit, after the finger has left the block"),
    "end": ("s", "measured", "instant of rest"),
    "theta0": ("rad", "measured", "release angle"),
    "zero": ("rad", "measured", "zero of theta during the run"),
    "theta0_u": ("rad", "quality", "total standard uncertainty of theta0"),
    "n_impacts": ("1", "measured", "number of sign changes of theta that stand out of the noise"),
    "impact_time": ("s", "measured", "instant of impact"),
    "peak_before": ("rad", "measured", "signed peak rotation before the impact"),
    "peak_after": ("rad", "measured", "signed peak rotation after the impact"),
    "peak_before_u": ("rad", "quality", "total standard uncertainty of peak_before"),
    "peak_after_u": ("rad", "quality", "total standard uncertainty of peak_after"),
    "restitution": ("1", "measured", "coefficient of restitution from the peaks before and after the impact"),
    "restitution_u": ("1", "quality", "total standard uncertainty of restitution"),
    "restitution_rate": ("1", "measured", "coefficient of restitution from the angular rates at the impact"),
    "restitution_energy": (
        "1",
        "model",
        "root of the ratio of mechanical energies after and before the impact, under the law",
    ),
    "restitution_energy_u": ("1", "quality", "total standard uncertainty of restitution_energy"),
    "peak_before_block": (
        "rad",
        "model",
        "peak_before of a measured impact, corrected for the sinking corner",
    ),
    "peak_after_block": ("rad", "model", "peak_after of a measured impact, corrected for the sinking corner"),
    "restitution_block": ("1", "model", "restitution of a measured impact, corrected for the sinking corner"),
    "restitution_block_u": ("1", "quality", "total standard uncertainty of restitution_block"),
    "impact_speed": ("m s-1", "model", "speed of the corner at touchdown, relative to the other corner"),
    "theta_uplift": ("rad", "measured", "amplitude below which the base stays in full contact"),
    "parameter": ("", "coordinate", "name of the parameter"),
    "parameter_b": ("", "coordinate", "name of the parameter"),
    "unit": ("", "auxiliary", "unit of the parameter"),
    "value": ("", "model", "identified value of the parameter"),
    "stderr": ("", "quality", "standard error of the parameter"),
    "initial": ("", "auxiliary", "value of the parameter from which the reported least squares started"),
    "min": ("", "auxiliary", "lower bound of the parameter in the fit"),
    "max": ("", "auxiliary", "upper bound of the parameter in the fit"),
    "vary": ("", "auxiliary", "whether the parameter was free, and not fixed or tied"),
    "expr": ("", "auxiliary", "expression that ties the parameter to others"),
    "ci95_low": ("", "quality", "lower end of the 95 % confidence interval of the parameter"),
    "ci95_high": ("", "quality", "upper end of the 95 % confidence interval of the parameter"),
    "covariance": ("", "quality", "covariance of the parameters"),
    "discrepancy": (
        "",
        "quality",
        "standard uncertainty of the parameter by errors of the law",
    ),
    "part_start": ("s", "auxiliary", "start of a part of the run since release"),
    "part_end": ("s", "auxiliary", "end of a part of the run since release"),
    "part_value": ("", "model", "value of the parameter fitted to a part of the run"),
    "u_total": ("", "quality", "total standard uncertainty of the parameter by noise, inputs and law"),
    "contribution": ("", "quality", "shift of the parameter for one standard uncertainty of the input"),
    "impact_of_input": (
        "",
        "quality",
        "shift of the parameter for one standard uncertainty of the input that remains after the fit",
    ),
    "input": ("", "coordinate", "quantity stated by the laboratory, on which the parameters depend"),
    "input_owner": ("", "auxiliary", "block, laser or foundation that has the input"),
    "input_u": ("", "auxiliary", "standard uncertainty of the input, in input_unit"),
    "input_unit": ("", "auxiliary", "unit of the input's uncertainty"),
    "input_stated": ("", "auxiliary", "whether the laboratory stated the uncertainty"),
    "input_moved": ("1", "quality", "shift of the input by the fit, in its standard uncertainties"),
    "input_remaining": (
        "1",
        "quality",
        "standard uncertainty of the input after the fit, over that before the fit",
    ),
    "input_pull": ("1", "quality", "shift of the input by the fit over the standard deviation of that shift"),
    "theta_model": ("rad", "model", "rotation of the model with the identified parameters"),
    "residual": ("rad", "model", "theta_model minus theta"),
    "epsilon_theta": ("1", "quality", "relative mean square discrepancy of theta_model from theta"),
    "epsilon_holdout": (
        "1",
        "quality",
        "epsilon_theta of the second half of the run, with parameters of the first half",
    ),
    "final_time": ("s", "auxiliary", "end of the fitted interval since release"),
    "aic": ("1", "quality", "Akaike information criterion"),
    "bic": ("1", "quality", "Bayesian information criterion"),
    "n_parameters": ("1", "auxiliary", "number of fitted parameters"),
    "success": ("", "quality", "whether the fit may be used"),
    "candidate": ("", "coordinate", "name of the candidate"),
    "status": ("", "quality", "result of the choice for the candidate"),
    "reason": ("", "quality", "reason of the status"),
    "explains": ("", "quality", "whether the candidate explains the run"),
    "n_freed": ("1", "auxiliary", "number of freed parameters on one run"),
    "epsilon_holdout_runs": (
        "1",
        "quality",
        "epsilon_theta of the run with the parameters of the record's other runs",
    ),
    "noise_p": ("1", "quality", "p-value of the residual against the noise at rest"),
    "noise_ratio": ("1", "quality", "power of the residual over power at rest, in the most significant band"),
    "noise_low_hz": ("Hz", "quality", "lower end of the most significant band"),
    "noise_high_hz": ("Hz", "quality", "upper end of the most significant band"),
    "added_damping": (
        "1",
        "quality",
        "value of a parameter that the law lacks, if added, over its standard error",
    ),
    "k": ("N m-2", "coordinate", "stiffness of the law"),
    "c": ("N s m-2", "coordinate", "damping of Winkler's law"),
    "lambda": ("N s m-3", "coordinate", "damping of Hunt–Crossley's law"),
    "k_finer": ("N m-2", "coordinate", "stiffness on the finer grid"),
    "c_finer": ("N s m-2", "coordinate", "damping on the finer grid"),
    "lambda_finer": ("N s m-3", "coordinate", "damping on the finer grid"),
    "epsilon_finer": (
        "1",
        "quality",
        "epsilon_theta on the finer grid, from interpolated theta(t)",
    ),
    "identified_run": ("", "auxiliary", "run of the identified values"),
    "identified_k": ("N m-2", "model", "identified stiffness"),
    "identified_c": ("N s m-2", "model", "identified damping"),
    "identified_lambda": ("N s m-3", "model", "identified damping"),
    "correlation": ("1", "quality", "correlation of the identified parameters"),
}
CONTENT = {
    "coordinate": "coordinate",
    "quality": "qualityInformation",
    "model": "modelResult",
    "auxiliary": "auxiliaryInformation",
    "measured": "physicalMeasurement",
}
IN_UNIT = {"comment": "in the unit that the variable unit gives for the parameter"}
EXTRA: dict[str, dict[str, Any]] = {
    "flags": {
        "standard_name": "quality_flag",
        "flag_masks": np.array(list(FLAGS.values()), np.uint8),
        "flag_meanings": " ".join(FLAGS),
    },
    "success": {"flag_values": np.array([0, 1], np.int8), "flag_meanings": "not_usable usable"},
    "explains": {"flag_values": np.array([0, 1], np.int8), "flag_meanings": "more_than_noise noise"},
    "vary": {"flag_values": np.array([0, 1], np.int8), "flag_meanings": "fixed_or_tied found"},
    "covariance": {
        "comment": "in the product of the units that the variable unit gives for the two parameters"
    },
    "input_stated": {"flag_values": np.array([0, 1], np.int8), "flag_meanings": "default stated"},
    **dict.fromkeys(
        ["value", "stderr", "ci95_low", "ci95_high", "discrepancy", "initial", "min", "max"], IN_UNIT
    ),
    **dict.fromkeys(
        ["u_total", "contribution", "impact_of_input", "part_value", "part_value_stderr"], IN_UNIT
    ),
}
BESIDE = {
    "theta": ("sigma_theta", "flags"),
    **{name: (f"{name}_u",) for name in ("theta0", *WITH_TOTAL)},
    "value": ("stderr", "ci95_low", "ci95_high", "discrepancy", "u_total", "unit"),
}
SAMPLES = {"time", "sample"}  # dimensions of what runs over time
SINGLE_PRECISION = {"sigma_theta", *(f"{name}{n}" for name in ("voltage", "current") for n in ("", "_2"))}


def describe(name: str, present: Container[object], simulated: bool) -> dict[str, Any]:
    """CF and ACDD attributes of a variable among those present beside it."""
    unit, content, long_name = VARIABLES[name.removesuffix("_stderr").removesuffix("_2")]
    if name.endswith("_stderr"):
        content, long_name = "quality", f"standard error of the {long_name}"
    elif content == "measured" and simulated:
        content = "model"
    attrs: dict[str, Any] = {"long_name": long_name, "coverage_content_type": CONTENT[content]}
    if unit:
        attrs["units"] = unit
    beside = [other for other in (f"{name}_stderr", *BESIDE.get(name, ())) if other in present]
    if beside:
        attrs["ancillary_variables"] = " ".join(beside)
    return attrs | EXTRA.get(name, {})


def root_attributes(product: str, done: str, attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Root attributes of a product; git is left to provenance.json: equal results are equal files."""
    made_by = attrs.get("provenance")
    if isinstance(made_by, Mapping):
        attrs = {**attrs, "provenance": {key: made_by[key] for key in made_by if key != "git"}}
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
