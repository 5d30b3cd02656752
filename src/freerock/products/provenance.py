"""What made a product: its inputs, configuration, versions of the software, state of the code.

Checksums of products are made in `jobs/make_report.py` and compared in `cli/verify_command.py`.
"""

import json
import platform
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from freerock.files import sha256
from freerock.products.root_text import root_text

SOFTWARE = ["freerock", "numpy", "scipy", "numba", "lmfit", "xarray", "netCDF4", "snakemake"]


def provenance(inputs: Iterable[str | Path], config: Mapping[str, Any]) -> dict[str, Any]:
    """What made a product, but the state of the code's checkout (`git_state`): equal results are equal files.

    Parameters
    ----------
    inputs : iterable of path
        Files that were read.
    config : mapping
        The part of the configuration that was used.

    Returns
    -------
    dict
        inputs (path -> sha256), config, software (name -> version).
    """
    return {
        "inputs": {Path(path).as_posix(): sha256(path) for path in inputs},
        "config": dict(config),
        "software": {"python": platform.python_version()} | {name: version(name) for name in SOFTWARE},
    }


def provenance_of_campaign(
    config: Mapping[str, Any], datasets: Mapping[str, Sequence[str | Path]]
) -> dict[str, Any]:
    """What made a campaign's products: `provenance`, the state of the code, what else made its datasets.

    Parameters
    ----------
    config : mapping
        The campaign's section of the configuration.
    datasets : mapping of str to (path, path)
        Record and fit dataset of each test.
    """
    raw: dict[str, str] = {}
    known: dict[str, dict[str, Any]] = {}
    for test, (record, fits) in datasets.items():
        known |= {f"records/{test}": made_by(record), f"fits/{test}": made_by(fits)}
        raw |= known[f"records/{test}"].get("inputs", {})
    own = provenance([], config) | {"inputs": raw, "git": git_state()}
    return own | {"other_software": other_software(known, own["software"])}


def other_software(
    made_by: Mapping[str, Mapping[str, Any]], software: Mapping[str, str]
) -> list[dict[str, Any]]:
    """By what else than this software datasets were made.

    Parameters
    ----------
    made_by : mapping of str to mapping
        What made records and fits (`made_by`), by their name.
    software : mapping
        Name to version, as `provenance` gives them.

    Returns
    -------
    list of dict
        software (name -> version, those that differ) and datasets (names), for each other set of versions.
    """
    found: dict[str, list[str]] = {}
    for name, each in made_by.items():
        versions = each.get("software", software)
        differing = {key: versions.get(key, "none") for key in {**versions, **software}}
        differing = {key: version for key, version in differing.items() if version != software.get(key)}
        if differing:
            found.setdefault(json.dumps(differing, sort_keys=True), []).append(name)
    return [{"software": json.loads(key), "datasets": names} for key, names in found.items()]


def made_by(path: str | Path) -> dict[str, Any]:
    """What made a record or its fits, as in `provenance`; empty where it is not known.

    Raises
    ------
    FreerockError
        No such file, or damaged.
    """
    return dict(json.loads(root_text(path, "provenance", "{}")))


def git_state() -> str:
    """State of the code's checkout; outside of one the version that is installed."""
    here = Path(__file__).resolve()
    try:
        for words in (f"ls-files --error-unmatch {here.name}", "describe --always --dirty --tags"):
            command = ["git", "-C", str(here.parent), *words.split()]
            done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=30)
    except (OSError, subprocess.SubprocessError):
        return f"freerock {version('freerock')} as installed"
    return done.stdout.strip()
