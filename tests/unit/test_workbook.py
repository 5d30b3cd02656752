"""The stand-in for a public workbook: its layout, its bytes, its label."""

import runpy
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

from openpyxl import load_workbook

from freerock.identification.fit import fit_run
from freerock.records.read import read_record
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.motion import motions_of
from freerock.runs.runs import find_runs

ROOT = Path(__file__).parents[2]
workbook = SimpleNamespace(**runpy.run_path(str(ROOT / "benchmarks/wooden_blocks.py")))
SHIPPED = ROOT / "raw/wooden_blocks" / workbook.FILE


def test_the_shipped_workbook_is_what_the_virtual_laboratory_writes(tmp_path):
    """Cell by cell: how openpyxl writes them depends on what else is installed."""
    workbook.write_campaign(tmp_path)
    assert (tmp_path / "truth.json").read_bytes() == (SHIPPED.parent / "truth.json").read_bytes()
    made, shipped = (load_workbook(path, read_only=True) for path in (tmp_path / workbook.FILE, SHIPPED))
    for one, other in zip(made, shipped, strict=True):
        assert list(one.iter_rows(values_only=True)) == list(other.iter_rows(values_only=True))


def fitted(name, model):
    """The fit of a model to the run of a block whose corners nobody measured."""
    block = replace(workbook.BLOCKS[name], contact_width_m=None)
    channel = read_record(SHIPPED, name)[name]
    time = channel["time"].values
    found = find_rotation(time, channel.values, Laser(units="deg"), block, "deg")
    theta, sigma = found["theta"].values, found["sigma_theta"].values
    (run,) = find_runs(time, theta, sigma, found["flags"].values, block)
    fit = fit_run(model, block, motions_of([run], {"time": time, "theta": theta})[run.number])
    assert fit.success
    return fit


def test_stiffness_damping_and_the_worn_width_are_recovered():
    fit = fitted("C3", workbook.TRUE)
    truth = workbook.TABLE | {"width": workbook.BLOCKS["C3"].contact_width_m}
    for (parameter, value), stderr in zip(fit.values.items(), fit.uncertainty.stderr, strict=True):
        if parameter in truth:
            assert abs(value - truth[parameter]) < 4 * stderr < 0.02 * value, parameter
