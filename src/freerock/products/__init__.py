"""Datasets of a campaign: netCDF in and out, names of variables, what a dataset holds, provenance."""
