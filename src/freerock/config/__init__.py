"""Configuration: YAML and CSV files in, checked campaigns and settings of each step out.

A key of a YAML file stands with its default in the module of its group: `lasers.range_m` in `lasers`. Those
of `plan` and `published` are in `campaign_file`, those of `fits` in `fit_settings`.
"""
