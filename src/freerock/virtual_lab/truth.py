"""The true values of a simulated campaign: truth.json beside its records."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from freerock.errors import FreerockError
from freerock.files import read_json, write_text
from freerock.models.laws import MODELS

REMEDY = "restore the file, or remove the key truth"


def write_truth(folder: str | Path, truth: Mapping[str, Any]) -> None:
    """Write truth.json into the folder of the records: what is true of each, by test."""
    write_text(Path(folder, "truth.json"), json.dumps(truth, indent=1, ensure_ascii=False) + "\n")


def read_truth(path: str | Path) -> dict[tuple[str, int, str, str], float]:
    """True value of each parameter [SI], by test, run, model and parameter.

    Raises
    ------
    FreerockError
        The file is missing, is not JSON, or lacks the model, the runs or the parameters of a test.
    """
    records = read_json(path, REMEDY)
    truth, where = {}, str(path)
    try:
        for test, record in records.items():
            where = f"{path}: {test}"
            model, names = record["model"], MODELS[record["model"]]
            for number, run in enumerate(record["runs"], 1):
                for name in names:
                    truth[test, number, model, name] = float(run[name])
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        what = f"does not hold the model and its parameters run by run ({type(error).__name__}: {error})"
        raise FreerockError(where, what, REMEDY) from None
    return truth
