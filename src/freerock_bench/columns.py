"""The tables of columns in docs/datasets.md: every CSV table of a campaign, with unit and meaning.

    python -m freerock_bench.columns docs/datasets.md

Columns come from docs/interface.json and from the code; units from the endings of their names.
"""

import json
import sys
from pathlib import Path

from freerock.jobs.respond import CURVE, SCENE
from freerock.planning import plan, plan_total
from freerock.response.ensemble import COLUMNS as RESPONSES
from freerock.tables import candidates, tidy
from freerock_bench.document import renew

ROOT = Path(__file__).parents[2]
MARK = ("<!-- columns -->\n\n", "\n\n<!-- end of the columns -->")
HEAD = "| column | unit | meaning |\n|---|---|---|"
UNITS = {
    "_n_m2": "N/m²",
    "_n_s_m2": "N·s/m²",
    "_n_s_m3": "N·s/m³",
    "_n_m3": "N/m³",
    "_m_s": "m/s",
    "_rad_s": "rad/s",
    "_s_m": "s/m",
    "_deg": "°",
    "_kg": "kg",
    "_hz": "Hz",
    "_percent": "%",
    "_m": "m",
    "_s": "s",
}
AS_PARAMETER = [  # columns in the unit of the row, where the table has a column `unit`
    *("value", "limit", "stderr", "ci95_low", "ci95_high", "discrepancy", "u_total", "contribution"),
    *("mean", "total95_low", "total95_high", "tau", "tau_low", "tau_high", "next_low", "next_high"),
    *("published", "truth", "half95", "u_total_without_first"),
]
LIKE = dict.fromkeys(("slope_stderr", "slope_low", "slope_high"), "slope_s_m")  # in the unit of another
ROWS = {  # table: what a row is
    "runs.csv": "run, and for each record without a run",
    "reasons.csv": "reason of a verdict",
    "parameters.csv": "run, model and parameter",
    "parts.csv": "run, model, parameter and sixth of the swings",
    "epsilon.csv": "run and model",
    "choice.csv": "run and candidate",
    "candidates.csv": "block, foundation and candidate",
    "restitution.csv": "impact, measured or of a model",
    "restitution_comparison.csv": "record",
    "restitution_law.csv": "block, foundation and quantity",
    "populations.csv": "level, model and parameter",
    "budget.csv": "mean and contribution to its uncertainty",
    "pulls.csv": "input of a run, if the residual agrees with the noise",
    "foundations.csv": "foundation, model and parameter",
    "predictions.csv": "run, model and basis",
    "fragility.csv": "record, intensity measure and point of the curve",
    "recovered.csv": "true parameter of a simulated run",
    "table1.csv": "block",
    "table2.csv": "record, model and parameter",
    "table3.csv": "record and model",
    "response/motions_N.csv": "record, ground motion, scale and draw",
    "plan/plan.csv": "case and parameter",
    "plan/rivals.csv": "case and rival",
    "plan/total.csv": "case, parameter and number of runs",
    "plan/budget.csv": "case, parameter and input",
}
COMMON = {
    "campaign": "name of the campaign",
    "test": "name of the record",
    "run": "number of the run in its record, from 1",
    "block": "name of the block",
    "foundation": "name of the foundation",
    "model": "law or candidate",
    "parameter": "name of the parameter: r, k, c, lambda, or another free one",
    "unit": "unit of the row's numbers",
    "origin": "simulated or measured",
}
MEANINGS = {
    "R_m": "distance of the nearer corner, at the contact width, from the centre of mass",
    "added_damping": "value of a lacking parameter, if added to the law, over its standard error",
    "aic": "Akaike's information criterion",
    "alpha_deg": "critical angle about the nearer corner; atan(b/h) of a uniform block, 2b its contact width",
    "basis": "source of k, c, λ, r (geometric means): other runs of the record, or another block; release, "
    "freed width, tilt and edges are those of the run's own fit",
    "beta": "dispersion of the fragility curve",
    "beta_high": "upper end of the 95 % interval of beta",
    "beta_low": "lower end of the 95 % interval of beta",
    "between_blocks_percent": "scatter between the means of blocks",
    "between_runs_percent": "scatter between the runs of each block",
    "bic": "Bayesian information criterion",
    "bic_difference": "BIC of the rival minus that of the expected model",
    "by_inputs_percent": "scatter between blocks that the inputs alone explain",
    "c_n_s_m2": "median damping c, if it is a parameter",
    "ci95_high": "upper end of the 95 % interval from noise",
    "ci95_low": "lower end of the 95 % interval from noise",
    "contact_width_m": "median contact width, if it is a parameter",
    "contribution": "shift of the mean for one standard uncertainty of the input",
    "contribution_fraction": "uncertainty by the input, as a share of the value",
    "discrepancy": "standard uncertainty by errors of the law; 0 if the run shows none",
    "draw": "number of the draw of parameters; draw 0 has the mean parameters",
    "duration_s": "time from release to rest",
    "end_s": "end of the part since release",
    "epsilon_high": "largest ε_θ of the runs",
    "epsilon_holdout": "ε_θ of the second half of the run with the parameters of the first half",
    "epsilon_holdout_runs": "ε_θ of the run with the law and width of the record's other runs (geometric "
    "means), its release refitted",
    "epsilon_in_phase": "ε_θ with the r of in_phase",
    "epsilon_low": "least ε_θ of the runs",
    "epsilon_theta": "discrepancy ε_θ (a fraction)",
    "error_percent": "error of the identified value",
    "excluded": "whether the run is excluded by hand",
    "explains": "whether the candidate explains the run",
    "f_p": "p-value of no difference between blocks",
    "f_ratio": "F of the test between blocks",
    "final_time_s": "end of the fitted interval since release",
    "first_impact_s": "mean time from release to the first impact",
    "first_input": "input with the largest contribution",
    "first_owner": "block, laser or foundation that has the first input",
    "first_share": "share of the first input in u_total²",
    "given": "fixed, undetermined, or the expression of a tied parameter; empty if free",
    "half95": "half-width of the 95 % interval, in the unit of the value",
    "height_m": "height 2h",
    "high": "upper end of the 95 % interval of the probability",
    "impact": "number of the impact in the run, from 1",
    "e": "median restitution e of a corner; this column and mu are absent if empty",
    "mu": "median friction μ of a corner",
    "impact_e_percent": "shift of e for one remaining standard uncertainty of the input; absent if empty",
    "impact_mu_percent": "shift of μ for one remaining standard uncertainty of the input; absent if empty",
    "impact_c_percent": "shift of c for one remaining standard uncertainty of the input",
    "impact_k_percent": "shift of k for one remaining standard uncertainty of the input",
    "impact_kappa_percent": "shift of κ for one remaining standard uncertainty of the input",
    "impact_lambda_percent": "shift of λ for one remaining standard uncertainty of the input",
    "impact_r_percent": "shift of r for one remaining standard uncertainty of the input",
    "impact_speed_m_s": "speed of the corner at touchdown, under the law",
    "in_phase": "r of the rigid block that keeps the phase, if the best fit stops too early",
    "input": "name of the input; also runs (scatter of the runs) and law (errors of the law)",
    "input_moved": "shift of the input by the fit, in its standard uncertainties",
    "input_owner": "block, laser or foundation that has the input",
    "input_pull": "shift of the input over the standard deviation of that shift",
    "input_remaining": "standard uncertainty of the input after the fit, over that before the fit",
    "input_stated": "1 if the laboratory stated the uncertainty, 0 for a default",
    "input_u": "standard uncertainty of the input",
    "input_unit": "unit of input_u",
    "inputs_fraction": "uncertainty from inputs, as a share of the value",
    "inputs_p": "p-value of no difference that allows for the inputs",
    "inside": "whether the 95 % interval holds the truth",
    "intensity": "intensity of the ground motion, in the unit of its measure",
    "k_n_m2": "median stiffness k, if it is a parameter",
    "kappa_n_m3": "median κ (stiffness k over the thickness of the bed), if it is a parameter",
    "key": "configuration key of the limit; empty if there is none",
    "kind": "fitted (point of the curve), counted (share of responses), none (no curve) or no_law (no "
    "law explains the runs, or no run is usable)",
    "lambda_n_s_m3": "median damping λ, if it is a parameter",
    "laser": "name of the laser",
    "level": "mean over the runs of a record, the records of a foundation, or the campaign",
    "limit": "threshold of the check",
    "low": "lower end of the 95 % interval of the probability",
    "mass_kg": "mass of the block",
    "max_theta_ratio": "largest |θ|/θ_cr of the response",
    "mean": "weighted mean (geometric; for r by logits)",
    "measure": "measure of intensity: pga_g or pgv_m_s",
    "median": "intensity at which half of the responses overturn",
    "median_high": "upper end of the 95 % interval of median",
    "median_low": "lower end of the 95 % interval of median",
    "motion": "name of the ground motion",
    "n": "number of responses",
    "n_also_possible": "runs in which the candidate is also possible",
    "n_blocks": "number of blocks",
    "n_explains": "runs that the candidate explains",
    "n_failed": "number of responses that could not be computed",
    "n_freed": "number of free parameters",
    "n_impacts": "impacts seen",
    "n_motions": "number of ground motions",
    "n_not_fitted": "runs to which the candidate was not fitted",
    "n_parameters": "number of fitted parameters",
    "n_records": "number of records",
    "n_rejected": "runs that reject the candidate",
    "n_restitution": "impacts with a restitution",
    "n_runs": "number of runs",
    "n_runs_rejected": "runs that reject the law",
    "n_selected": "runs in which the candidate is selected",
    "next_high": "upper end of the 95 % prediction interval of the next run or record",
    "next_low": "lower end of the 95 % prediction interval of the next run or record",
    "noise_high_hz": "upper end of the most significant band",
    "noise_low_hz": "lower end of the most significant band",
    "noise_p": "p-value of the residual against the noise at rest",
    "noise_ratio": "power of the residual over power at rest, in the most significant band",
    "note": "remark on the case",
    "overturned": "1 if the block overturns, else 0; empty if the computation failed",
    "p_rad_s": "rate √(m g R/I), I about the nearer corner; √(3g/4R) of a uniform block of full width",
    "part": "number of the part, from 1",
    "peak_before_block_deg": "peak before the impact, corrected for the sinking corner",
    "peak_before_deg": "peak before the impact, signed",
    "peak_before_u_deg": "total uncertainty of peak_before_deg",
    "pga_g": "peak ground acceleration in g",
    "pgv_m_s": "peak ground velocity",
    "pgv_over_pga_s": "peak ground velocity over peak ground acceleration",
    "probability": "probability of overturning",
    "published": "published value",
    "quantity": "definition of r: peaks (speed of a rigid block that falls from the measured peak) or energy "
    "(speed under the law selected for the run, else that of least ε_θ)",
    "r": "restitution from peaks",
    "r_block": "restitution from peaks that are corrected for the sinking corner",
    "r_block_u": "total uncertainty of r_block",
    "r_energy": "restitution by energy under the law",
    "r_energy_stderr": "standard error of r_energy",
    "r_energy_u": "total uncertainty of r_energy",
    "r_fitted": "mean r of Housner's fits",
    "r_fitted_stderr": "standard error of r_fitted",
    "r_first": "mean r of the first impact",
    "r_high": "largest r of an impact",
    "r_housner": "ideal restitution of the stated block; 1 − 1.5 sin² θ_cr if uniform and of full width",
    "r_low": "least r of an impact",
    "r_median": "median r of all impacts",
    "r_stderr": "standard error of r",
    "r_u": "total uncertainty of r",
    "reason": "name of the reason",
    "reasons": "all reasons of the verdict, as text",
    "rejected": "whether most runs reject the model",
    "release_angle_deg": "release angle; in table1 the mean of all runs",
    "release_angle_nominal_deg": "nominal release angle",
    "release_angle_std_deg": "standard deviation of the release angle between runs",
    "release_s": "instant of release in the record",
    "rigid_s": "time to the first impact of a rigid block with the same release angle",
    "rival": "rival candidate",
    "runs_fraction": "uncertainty from the scatter between runs, as a share of the value",
    "sampling_rate_hz": "sampling rate",
    "scale": "factor on the ground motion",
    "scatter_p": "p-value of τ = 0",
    "selected": "whether the model is selected, in table2 and table3 by most runs",
    "sensitivity": "shift of the mean per unit of the input",
    "sensor": "name of the planned sensor",
    "sentence": "the reason as a sentence",
    "share_percent": "share of u_total²",
    "shared": "whether no difference between blocks was found; empty if unknown",
    "sigma_theta_deg": "standard deviation of the noise of θ",
    "slenderness": "height over width",
    "slope_high": "upper end of the 95 % interval of the slope",
    "slope_low": "lower end of the 95 % interval of the slope",
    "slope_s_m": "slope dr/dv of r against impact speed",
    "slope_stderr": "standard error of the slope",
    "source": "experiment, or name of the model",
    "speed_high_m_s": "largest impact speed",
    "speed_low_m_s": "least impact speed",
    "speed_m_s": "median impact speed",
    "spread_fraction": "assumed spread between runs over their mean",
    "start_s": "start of the part since release",
    "status": "selected, also_possible, rejected or not_fitted",
    "stderr": "standard error by noise; of a mean also by the scatter of its members",
    "success": "whether the fit may be used",
    "tau": "spread τ between runs or records, without their noise",
    "tau_high": "upper end of the 95 % interval of tau",
    "tau_low": "lower end of the 95 % interval of tau",
    "theta0_deg": "release angle",
    "theta0_u_deg": "total uncertainty of theta0_deg",
    "tilt_stderr_deg": "standard error of a tilt of the base",
    "time_s": "instant of the impact since release",
    "told_apart": "whether a run will reject the rival",
    "total95_high": "upper end of the 95 % interval from u_total",
    "total95_low": "lower end of the 95 % interval from u_total",
    "trend": "whether the interval of the slope excludes zero",
    "truth": "true value",
    "u_total": "total standard uncertainty by noise, scatter, inputs and law",
    "u_total_without_first": "u_total if the first input were exact",
    "value": "identified value",
    "verdict": "ok, warn or fail",
    "visible_percent": "difference between two blocks that the test finds with a probability of 80 %",
    "width_m": "width 2b",
}
OWN = {  # meanings in one table alone
    ("choice.csv", "reason"): "reason of the status",
    ("reasons.csv", "value"): "value that the check compares with the limit",
    ("reasons.csv", "verdict"): "verdict of this reason",
    ("candidates.csv", "r"): "median r, if it is a parameter",
    ("candidates.csv", "epsilon_theta"): "median ε_θ (a fraction)",
    ("candidates.csv", "epsilon_holdout"): "median ε_θ of second halves",
    (
        "restitution_law.csv",
        "r",
    ): "restitution at the median speed, mean of lines through runs with four or more impacts "
    "(unweighted, without errors of inputs)",
    ("parts.csv", "value"): "value fitted to this part",
    ("parts.csv", "stderr"): "standard error, if the noise is white",
    ("table3.csv", "epsilon_theta"): "median ε_θ of the runs (a fraction)",
    ("table3.csv", "published"): "published ε_θ (a fraction)",
    ("plan/plan.csv", "value"): "expected value",
    ("plan/plan.csv", "stderr"): "predicted standard error from noise",
    ("plan/total.csv", "value"): "expected value",
    ("plan/total.csv", "u_total"): "total standard uncertainty of the mean",
    ("plan/rivals.csv", "epsilon_theta"): "ε_θ between the motions of rival and expected model",
}


def tables() -> dict[str, list[str]]:
    """Columns of each table, in the order of `ROWS`."""
    listed = json.loads((ROOT / "docs/interface.json").read_text(encoding="utf-8"))["columns"]
    own = {
        "fragility.csv": CURVE,
        "response/motions_N.csv": [*SCENE, *RESPONSES],
        "plan/plan.csv": plan.COLUMNS,
        "plan/rivals.csv": plan.RIVALS,
        "plan/total.csv": plan_total.TOTALS,
        "plan/budget.csv": plan_total.BUDGET,
    }
    found = {name: (listed | own)[name] for name in ROWS}
    rare = {"candidates.csv": candidates.RARE_COLUMNS, "pulls.csv": tidy.RARE_IMPACTS}
    return found | {name: [*found[name], *rare[name]] for name in rare}


def markdown() -> str:
    """The columns that tables share, then a table for each file."""
    common = [row("", name, meaning) for name, meaning in COMMON.items()]
    parts = ["\n".join(["### Columns of several tables", "", HEAD, *common])]
    for table, names in tables().items():
        shared = ", ".join(f"`{name}`" for name in names if name in COMMON)
        rows = [row(table, name, meaning_of(table, name)) for name in names if name not in COMMON]
        parts.append(
            "\n".join(
                [
                    f"### {table}",
                    "",
                    f"One row for each {ROWS[table]}. It has {shared}, and:",
                    "",
                    HEAD,
                    *rows,
                ]
            )
        )
    return "\n\n".join(parts)


def meaning_of(table: str, name: str) -> str:
    """What a column of a table means."""
    return OWN.get((table, name)) or MEANINGS[name]


def row(table: str, name: str, meaning: str) -> str:
    """A row of a table."""
    return f"| `{name}` | {unit_of(table, name)} | {meaning} |"


def unit_of(table: str, name: str) -> str:
    """The unit that the ending of a name says, or the row of a table where that has one."""
    if name in AS_PARAMETER and table and "unit" in tables()[table]:
        return "`unit`"
    return next((unit for ending, unit in UNITS.items() if LIKE.get(name, name).endswith(ending)), "")


if __name__ == "__main__":
    renew(sys.argv[1], MARK, markdown())
