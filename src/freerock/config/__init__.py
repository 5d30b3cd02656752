"""Configuration: YAML and CSV files in, checked campaigns, scenes and settings of each step out."""

__all__ = [
    "campaign",
    "csv_cells",
    "default_uncertainties",
    "defaults",
    "figure_names",
    "hand_corrections",
    "keys",
    "laser_section",
    "mistakes",
    "record",
    "reference",
    "review_log",
    "scene",
    "step_settings",
    "values",
]
