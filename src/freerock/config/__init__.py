"""Configuration: YAML and CSV files in, checked campaigns and scenes out, and what each step gets of them."""

__all__ = [
    "campaign",
    "history",
    "keys",
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
