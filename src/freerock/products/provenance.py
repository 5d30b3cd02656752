"""What made a product: its inputs, configuration, versions of the software, state of the code."""

import json
import platform
import re
import subprocess
from collections.abc import Iterable, Mapping
from contextlib import suppress
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


def other_software(datasets: Mapping[str, xr.DataTree], software: Mapping[str, str]) -> list[dict[str, Any]]:
    """By what else than this software datasets were made.

    Parameters
    ----------
    datasets : mapping of str to xarray.DataTree
        Records and fits by name.
    software : mapping
        Name to version, as `provenance` gives them.

    Returns
    -------
    list of dict
        software (name -> version, those that differ) and datasets (names), for each other set of versions.
    """
    found: dict[str, list[str]] = {}
    for name, tree in datasets.items():
        versions = json.loads(tree.attrs.get("provenance", "{}")).get("software", software)
        differing = {key: versions.get(key, "none") for key in {**versions, **software}}
        differing = {key: version for key, version in differing.items() if version != software.get(key)}
        if differing:
            found.setdefault(json.dumps(differing, sort_keys=True), []).append(name)
    return [{"software": json.loads(key), "datasets": names} for key, names in found.items()]


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
        return _archived_state(here)
    return done.stdout.strip()


def _archived_state(here: Path) -> str:
    """State of the code as an archive without git tells it, in the manner of `git archive`."""
    with suppress(OSError, IndexError):
        text = (here.parents[3] / ".git_archival.txt").read_text(encoding="utf-8")
        if found := re.search(r"^describe-name: (\S+)$", text, re.M):
            return found[1]
    return "unknown"
