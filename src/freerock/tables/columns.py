"""The columns of the tables of a campaign, in their order, as `RUNS_COLUMNS` of runs.csv.

A column is renamed here, in the module that makes its rows (`tidy_tables`, `populations` or that of the
table's name), and where `grep -rn NAME src docs` finds it read; the old one stays beside it for one version.
Elsewhere are the columns of tables of other packages, predictions and foundations (`populations.predict`,
`populations.shared_foundation`), plans (`planning.plan`), and of tables 1 to 3 and
recovered (`summary`).
"""

from itertools import chain

from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import LAWS, MODELS, PAPER_MODELS
from freerock.products.choices import CHOICE_NUMBERS, TESTS

SCENE_COLUMNS = ["campaign", "block", "foundation"]
COUNTS = {f"n_{status}": status for status in ("selected", "also_possible", "rejected", "not_fitted")}


def _column(name: str) -> str:
    """Column of the median of a parameter: its name and unit."""
    unit = PARAMETERS[name].unit
    name = "contact_width" if name == "width" else name
    return name if unit == "1" else f"{name}_{unit.replace('-', '').replace(' ', '_').lower()}"


_OF_LAWS = [name for law in LAWS.values() for name in law.parameters]
_PUBLISHED = [name for model in PAPER_MODELS for name in LAWS[model].parameters]
MEDIANS = {_column(name): name for name in dict.fromkeys([*_PUBLISHED, "width", *_OF_LAWS])}
_USUAL = [name for law in LAWS.values() if law.by_default for name in law.parameters]
RARE = [name for name in _OF_LAWS if name not in _USUAL]
CANDIDATES_COLUMNS = [*SCENE_COLUMNS, "model", "n_freed", "n_runs", *COUNTS, "n_explains"]
CANDIDATES_COLUMNS += ["epsilon_theta", "epsilon_holdout"]
CANDIDATES_COLUMNS += [name for name, own in MEDIANS.items() if own not in RARE]
# Last, where any is not empty.
RARE_CANDIDATES_COLUMNS = [name for name, own in MEDIANS.items() if own in RARE]

INPUT_COLUMNS = ["input", "input_owner", "input_u", "input_unit", "input_stated"]
OF_MEAN = ["campaign", "level", "test", "block", "foundation", "model", "parameter", "unit", "n_runs"]
POPULATIONS_COLUMNS = [*OF_MEAN, "n_records", "mean", "stderr", "ci95_low", "ci95_high"]
POPULATIONS_COLUMNS += ["u_total", "total95_low", "total95_high", "tau", "tau_low", "tau_high"]
POPULATIONS_COLUMNS += ["next_low", "next_high", "scatter_p"]
BUDGET_COLUMNS = [*OF_MEAN, *INPUT_COLUMNS, "mean", "u_total", "sensitivity", "contribution", "share_percent"]

IDENTITY = ["campaign", "test", "run", "block", "foundation"]
RUNS_COLUMNS = [*IDENTITY, "origin", "theta0_deg", "theta0_u_deg", "release_s", "duration_s", "n_impacts"]
RUNS_COLUMNS += ["n_restitution", "sigma_theta_deg", "verdict", "reasons", "excluded"]
REASONS_COLUMNS = [*IDENTITY, "verdict", "reason", "value", "limit", "unit", "key", "sentence"]
PARAMETERS_COLUMNS = [*IDENTITY, "model", "parameter", "value", "stderr", "ci95_low", "ci95_high"]
PARAMETERS_COLUMNS += ["discrepancy", "u_total", "unit", "success", "given", "in_phase"]
PARTS_COLUMNS = [*IDENTITY, "model", "parameter", "unit", "part", "start_s", "end_s", "value", "stderr"]
MOVED_COLUMNS = [*INPUT_COLUMNS, "input_moved", "input_remaining", "input_pull"]
IMPACTS = [
    f"impact_{name}_percent"
    for name in dict.fromkeys(chain.from_iterable(MODELS.values()))
    if name not in RARE
]
RARE_IMPACTS = [f"impact_{name}_percent" for name in RARE]
PULLS_COLUMNS = [*IDENTITY, "model", *MOVED_COLUMNS, *IMPACTS]
CONTRIBUTIONS_COLUMNS = [*IDENTITY, "model", "parameter", "value", *INPUT_COLUMNS, "contribution"]
EPSILON_COLUMNS = [*IDENTITY, "model", "epsilon_theta", "final_time_s", "epsilon_holdout", "n_parameters"]
EPSILON_COLUMNS += ["aic", "bic", "selected", "success", "epsilon_in_phase"]
CHOICE_COLUMNS = [*IDENTITY, "model", "status", "explains", "n_freed", *CHOICE_NUMBERS, *TESTS, "reason"]
RESTITUTION_COLUMNS = ["campaign", "test", "run", "source", "impact", "time_s", "r", "r_stderr", "r_u"]
RESTITUTION_COLUMNS += ["block", "foundation", "peak_before_deg"]
RESTITUTION_COLUMNS += ["peak_before_u_deg", "r_energy", "r_energy_stderr"]
RESTITUTION_COLUMNS += ["r_energy_u", "impact_speed_m_s", "r_block", "r_block_u", "peak_before_block_deg"]
RESTITUTION_COMPARISON_COLUMNS = ["campaign", "test", "block", "foundation", "r_fitted", "r_fitted_stderr"]
RESTITUTION_COMPARISON_COLUMNS += ["r_first", "r_median", "r_low"]
RESTITUTION_COMPARISON_COLUMNS += ["r_high", "first_impact_s", "rigid_s", "r_housner"]
RESTITUTION_COMPARISON_COLUMNS += ["r_fitted_u", "r_first_u", "r_median_u"]
