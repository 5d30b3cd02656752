"""Configuration: YAML and CSV files in, checked campaigns, scenes and settings of each step out."""

__all__ = [
    "campaign",
    "defaults",
    "keys",
    "mistakes",
    "override",
    "record",
    "reference",
    "review_log",
    "scene",
    "sensor",
    "step_settings",
    "uncertainty",
    "values",
]
