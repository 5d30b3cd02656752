"""The stand-in for a public workbook: its layout, its bytes, its label."""

import math
from dataclasses import replace
from pathlib import Path

from openpyxl import load_workbook

from freerock.config.campaign import load_campaign
from freerock.identification.fit import fit_run
from freerock.records.read import read_record
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.motion import motion_of
from freerock.runs.segment import find_runs
from freerock.selection.allowed_hypotheses import candidates
from freerock_bench import workbook

ROOT = Path(__file__).parents[2]
SHIPPED = ROOT / "raw/wooden_blocks" / workbook.FILE


def test_layout_second_sheet_three_rows_of_headings_and_pairs_of_columns():
    book = load_workbook(SHIPPED, read_only=True)
    first, sheet = book.worksheets
    assert "SIMULATED" in first["A1"].value
    heads = [[cell.value for cell in row] for row in sheet.iter_rows(max_row=4)]
    assert heads[0][::2] == list(workbook.BLOCKS) == ["A1", "A2", "A3", "B1", "B2", "B3", "C1", "C2", "C3"]
    assert heads[1] == ["time", "θ"] * 9
    assert heads[3] == [0, *heads[3][1:]]
    book.close()


def test_the_shipped_workbook_is_what_the_virtual_laboratory_writes(tmp_path):
    workbook.write_campaign(tmp_path)
    for name in (workbook.FILE, "truth.json", "manifest.csv"):
        assert (tmp_path / name).read_bytes() == (SHIPPED.parent / name).read_bytes(), name


def test_each_pair_is_a_channel_of_its_own_time():
    for name, block in workbook.BLOCKS.items():
        record = read_record(SHIPPED, name)
        assert record[name].attrs["units"] == "deg"
        assert math.isclose(record.attrs["sampling_rate_hz"], workbook.RATE_HZ, rel_tol=1e-9)
        held = float(record[name].sel(time=slice(2.2, 3.2)).mean())
        assert math.isclose(held, math.degrees(0.6 * block.theta_cr), abs_tol=5e-3)


def test_the_campaign_gives_the_shapes_but_not_the_worn_corners():
    wood = load_campaign(ROOT / "config/campaigns/wooden_blocks.yaml")
    assert wood.origin == "simulated"
    for name, block in workbook.BLOCKS.items():
        section = wood.blocks[name]
        assert (section.height_m, section.width_m, section.mass_kg) == (
            block.height_m,
            block.width_m,
            block.mass_kg,
        )
        assert section.contact_width_m is None
    every = candidates(wood.fits.models, wood.fits.rivals, wood.fits.freed)
    assert workbook.TRUE in every and "housner_width" in every


def fitted(name, model):
    """The fit of a model to the run of a block whose corners nobody measured."""
    block = replace(workbook.BLOCKS[name], contact_width_m=None)
    channel = read_record(SHIPPED, name)[name]
    time = channel["time"].values
    found = find_rotation(time, channel.values, Laser(units="deg"), block, "deg")
    theta, sigma = found["theta"].values, found["sigma_theta"].values
    (run,) = find_runs(time, theta, sigma, found["flags"].values, block)
    fit = fit_run(model, block, motion_of(run, time, theta))
    assert fit.success
    return fit


def test_stiffness_damping_and_the_worn_width_are_recovered():
    fit = fitted("C3", workbook.TRUE)
    truth = workbook.TABLE | {"width": workbook.BLOCKS["C3"].contact_width_m}
    for parameter, value, stderr in zip(fit.parameters, fit.value, fit.stderr, strict=True):
        if parameter in truth:
            assert abs(value - truth[parameter]) < 4 * stderr < 0.02 * value, parameter
