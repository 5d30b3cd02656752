"""The tables of variables in docs/datasets.md, from the vocabulary of the datasets.

python -m freerock_bench.variables docs/datasets.md
"""

import sys

from freerock.products.names import VARIABLES
from freerock.rotation.flags import BY_HAND, FLAGS
from freerock_bench.document import renew

MARK = ("<!-- variables -->\n\n", "\n\n<!-- end of the variables -->")
SIGNAL = "voltage current displacement rotation"
HEAD = "| variable | dimensions | unit | content |\n|---|---|---|---|"
WHERE: dict[str, dict[str, str]] = {  # heading: names by the dimensions they have
    "records/TEST.nc": {
        "time": f"time theta sigma_theta flags {SIGNAL} translation position_x position_z",
        "fault_number": "fault fault_start fault_end fault_note fault_angle",
    },
    "records/TEST.nc, group run_N": {
        "": "hold_start release fit_start end theta0 theta0_u zero sigma_theta n_impacts theta_uplift",
        "impact": "impact_time peak_before peak_before_u peak_after peak_after_u restitution restitution_u "
        "restitution_rate restitution_energy restitution_energy_u impact_speed",
    },
    "fits/TEST.nc, group run_N/MODEL": {
        "parameter": "parameter unit value stderr ci95_low ci95_high discrepancy u_total initial min "
        "max vary expr",
        "parameter, parameter_b": "parameter_b covariance correlation",
        "time": "theta_model residual",
        "part": "part_start part_end",
        "part, parameter": "part_value",
        "parameter, input": "contribution impact_of_input",
        "input": "input input_owner input_u input_unit input_stated input_moved input_remaining input_pull",
        "": "epsilon_theta epsilon_holdout final_time aic bic n_parameters success",
    },
    "fits/TEST.nc, group run_N/choice": {
        "candidate": "candidate status reason explains n_freed epsilon_theta epsilon_holdout "
        "epsilon_holdout_runs bic noise_p noise_ratio noise_low_hz noise_high_hz added_damping",
        "impact": "peak_before_block peak_after_block restitution_block restitution_block_u",
    },
    "misfit_map.nc": {
        "c or lambda, k": "epsilon_theta",
        "": "k c lambda k_finer c_finer lambda_finer",
        "c_finer or lambda_finer, k_finer": "epsilon_finer",
        "identified": "identified_run identified_k identified_c identified_lambda correlation",
    },
}


def markdown() -> str:
    """A table for each file and group: variable, dimensions, unit, content."""
    parts = []
    for where, by_dimensions in WHERE.items():
        rows = [row(name, dims) for dims, names in by_dimensions.items() for name in names.split()]
        parts.append("\n".join([f"### {where}", "", HEAD, *rows]))
    bits = ", ".join(f"{bit} {name.replace('_', ' ')}" for name, bit in (FLAGS | BY_HAND).items())
    return "\n\n".join([*parts, f"Bits of `flags`: {bits}; 0 is valid."])


def row(name: str, dimensions: str) -> str:
    """A row of a table, as the attributes of the variable have it."""
    unit, _, meaning = VARIABLES[name]
    return f"| `{name}` | {dimensions} | {unit} | {meaning} |"


if __name__ == "__main__":
    renew(sys.argv[1], MARK, markdown())
