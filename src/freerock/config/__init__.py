"""Configuration: YAML and CSV files in, checked campaigns, scenes and settings of each step out."""

__all__ = [
    "campaign",
    "csv_cells",
    "defaults",
    "keys",
    "laser_section",
    "mistakes",
    "override",
    "record",
    "reference",
    "review_log",
    "scene",
    "step_settings",
    "uncertainty",
    "values",
]
