"""What made a product: its inputs, configuration, versions of the software, state of the code."""

import json
import platform
import subprocess
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import xarray as xr

from freerock.files import sha256

SOFTWARE = ["freerock", "numpy", "scipy", "numba", "lmfit", "xarray", "netCDF4", "snakemake"]


def provenance(inputs: Iterable[str | Path], config: Mapping[str, Any]) -> dict[str, Any]:
    """What made a product.

    Parameters
    ----------
    inputs : iterable of path
        Files that were read.
    config : mapping
        The part of the configuration that was used.

    Returns
    -------
    dict
        inputs (path -> sha256), config, software (name -> version), git (state of the code's checkout,
        "unknown" outside of one).
    """
    return {
        "inputs": {Path(path).as_posix(): sha256(path) for path in inputs},
        "config": dict(config),
        "software": _software(),
        "git": _git_state(),
    }


def inputs_of(record: xr.DataTree) -> dict[str, str]:
    """SHA-256 by path of the raw files of a record; none where it failed for an unforeseen reason."""
    made_by = json.loads(record.attrs.get("provenance", '{"inputs": {}}'))
    return dict(made_by["inputs"])


@cache
def _software() -> dict[str, str]:
    return {"python": platform.python_version()} | {name: version(name) for name in SOFTWARE}


@cache
def _git_state() -> str:
    here = Path(__file__).resolve()
    try:
        for command in (
            ["ls-files", "--error-unmatch", here.name],
            ["describe", "--always", "--dirty", "--tags"],
        ):
            done = subprocess.run(
                ["git", *command], cwd=here.parent, capture_output=True, text=True, check=True, timeout=30
            )
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return done.stdout.strip()
