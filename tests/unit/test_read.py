import subprocess
import sys
from pathlib import Path

import pytest
from reading import refusal

from freerock.errors import FreerockError
from freerock.records.read import READERS, read_record

EXAMPLES = Path(__file__).parents[3] / "shared/data/acquisition"


def test_missing_file(tmp_path):
    assert refusal(tmp_path / "gone.tdms") == ("no such file; put it there, or correct its name")
    assert refusal(tmp_path) == "is a folder; name the files in it"


def test_unknown_format(tmp_path):
    path = tmp_path / "record.abc"
    path.touch()
    assert refusal(path).startswith("unknown format '.abc'; use one of .tdms, .lvm, .csv, ")


def test_empty_file(tmp_path):
    path = tmp_path / "record.tdms"
    path.touch()
    assert refusal(path) == "the file is empty; copy it again from the acquisition computer"


def test_reader_is_imported_only_when_needed():
    code = "import sys, freerock.records.read; sys.exit(not {'nptdms', 'xarray'}.isdisjoint(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_format_is_documented():
    table = (Path(__file__).parents[2] / "docs/records.md").read_text(encoding="utf-8")
    assert all(f"`{suffix}`" in table for suffix in READERS)


@pytest.mark.skipif(not EXAMPLES.is_dir(), reason="the example files are not here")
def test_every_example_file_is_read_or_refused():
    outcomes = {}
    for path in sorted(p for p in EXAMPLES.rglob("*") if p.is_file()):
        try:
            outcomes[path.name] = read_record(path)
        except FreerockError as error:
            assert str(error).startswith(f"{path}: ") and "\n" not in str(error)
    assert len(outcomes) >= 13
    scaled = outcomes["daqmx_polynomial_voltage.tdms"]["PXI1Slot7/ai0"]
    assert scaled.attrs["units"] == "Volts" and abs(scaled[0] - 3.648018) < 1e-6
    assert outcomes["short.lvm"]["Response (Trigger)"][0] == 1.204792
    assert outcomes["long_single_header_multi_ch.lvm"].sizes["time"] == 16384
