"""Configuration: YAML and CSV files in, checked campaigns, scenes and settings of each step out."""

__all__ = [
    "campaign",
    "history",
    "keys_and_defaults",
    "mistakes",
    "override",
    "record",
    "reference",
    "scene",
    "sensor",
    "step_settings",
    "uncertainty",
    "values",
]
