"""Datasets: netCDF in and out, names of variables, provenance."""
