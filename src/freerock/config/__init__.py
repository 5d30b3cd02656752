"""Configuration: YAML and CSV files in, checked campaigns and settings of each step out.

A key of a YAML file stands with its default in the module of its group: `plan.sensors` in `keys_of_plan`.
Those that code takes as a whole are in `fit_settings` and `laser_defaults`.
"""

__all__ = [
    "campaign",
    "csv_cells",
    "figure_names",
    "fit_settings",
    "hand_corrections",
    "keys_of_blocks",
    "keys_of_campaign",
    "keys_of_fits",
    "keys_of_lasers",
    "keys_of_plan",
    "keys_of_processing",
    "keys_of_uncertainty",
    "laser_defaults",
    "mistakes",
    "record",
    "reference",
    "review_log",
    "step_settings",
    "values",
]
