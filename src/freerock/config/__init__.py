"""Configuration: YAML and CSV files in, checked campaigns and scenes out."""
