"""Datasets of a campaign: netCDF in and out, names of variables, what a dataset holds, provenance."""

__all__ = [
    "choices",
    "estimates",
    "groups",
    "names",
    "netcdf",
    "paper_fits",
    "provenance",
    "runs",
    "verdict_with_fits",
]
