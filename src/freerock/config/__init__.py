"""Configuration: YAML and CSV files in, checked campaigns and scenes out, and what each step gets of them."""

__all__ = ["campaign", "keys", "mistakes", "override", "record", "scene", "sensor", "step_settings", "values"]
