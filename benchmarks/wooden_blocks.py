"""A simulated stand-in for a public workbook of rotations θ(t), in its layout.

    python benchmarks/wooden_blocks.py raw/wooden_blocks

The University of Catania published the rotations of nine wooden blocks in free rocking (Zenodo record
6670588) as an Excel workbook: on its second sheet, below three rows of headings, a pair of columns (time
and θ) for each of the blocks A1 to C3. Nothing of that data is in here. Shapes, masses, foundation and
motions are made up; only the layout is that of the workbook, so that the real one can take this file's place.

The blocks are as real ones are: they turn about their corners, and the corners are worn.
"""

import re
import sys
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from freerock.files import atomic, write_manifest
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, Rules
from freerock.rotation.sensor import Laser
from freerock.virtual_lab.virtual_record import Recording, VirtualRecord, VirtualRelease, simulate_record
from freerock.virtual_lab.write_tdms import write_truth

FILE = "free_rocking.xlsx"
TRUE = "hunt_crossley_pivoting_width"  # the width that the campaign states is that of sound corners
TABLE = {"k": 2.0e6, "lambda": 6.0e7}
WIDTHS_M = {"A": 0.12, "B": 0.09, "C": 0.06}
HEIGHT_OVER_WIDTH = {"1": 5.0, "2": 4.0, "3": 3.0}
WORN = 0.92  # corners: what is left of the width
DENSITY_KG_M3, DEPTH_M = 600.0, 0.12
RATE_HZ, NOISE_DEG = 200.0, 0.01
BLOCKS = {
    size + shape: Block(
        round(ratio * width, 4),
        width,
        round(DENSITY_KG_M3 * DEPTH_M * ratio * width**2, 3),
        round(WORN * width, 5),
    )
    for size, width in WIDTHS_M.items()
    for shape, ratio in HEIGHT_OVER_WIDTH.items()
}


def records(seed: int = 6670588) -> Iterator[tuple[str, VirtualRecord]]:
    """Name and record of each block: one release from 0.6 times the critical angle."""
    generator = np.random.RandomState(seed)
    for name, block in BLOCKS.items():
        theta0 = round(0.6 * block.theta_cr, 5)
        release = VirtualRelease(theta0, TABLE, tilt_s=1.0, held_s=1.5, fade_s=0.01, pause_s=1.5)
        own = int(generator.randint(2**31))
        laser = Laser("horizontal", 0.7 * block.height_m, 1.0)  # its reading is not used
        yield (
            name,
            simulate_record(
                block,
                laser,
                CANDIDATES[TRUE].law,
                [release],
                seed=own,
                recording=Recording(rate_hz=RATE_HZ, rest_s=1.0),
                rules=Rules(kinematics=CANDIDATES[TRUE].kinematics),
            ),
        )


def write_workbook(path: str | Path, pairs: Mapping[str, tuple[Sequence[float], Sequence[float]]]) -> None:
    """Write (time [s], θ [deg]) of each block as columns of the second sheet; the same bytes each time."""
    from openpyxl import Workbook

    book = Workbook()
    note = book.active
    note.title = "read me"
    note.append(["SIMULATED: made up by freerock.virtual_lab. Nothing in this workbook was measured."])
    note.append(["Layout after the workbook of Zenodo record 6670588, whose data are not in here."])
    sheet = book.create_sheet("free rocking")
    sheet.append([cell for name in pairs for cell in (name, None)])
    sheet.append(["time", "θ"] * len(pairs))
    sheet.append(["[s]", "[deg]"] * len(pairs))
    for row in range(max(len(time) for time, _ in pairs.values())):
        cells = [
            (time[row], theta[row]) if row < len(time) else (None, None) for time, theta in pairs.values()
        ]
        sheet.append([cell for pair in cells for cell in pair])
    with atomic(path) as partial:
        book.save(partial)
        _without_dates(Path(partial))


def _without_dates(path: Path) -> None:
    """Replace the moments of writing in a workbook by a fixed one."""
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in parts.items():
            if name == "docProps/core.xml":
                content = re.sub(rb"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", b"2022-01-01T00:00:00Z", content)
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)


def write_campaign(folder: str | Path) -> None:
    """Write the workbook, truth.json and manifest.csv."""
    folder = Path(folder)
    truth: dict[str, Any] = {}
    pairs: dict[str, tuple[list[float], list[float]]] = {}
    for name, record in records():
        generator = np.random.RandomState(record.truth["seed"])
        noise = NOISE_DEG * generator.standard_normal(record.theta.size)
        pairs[name] = (
            [round(float(t), 4) for t in record.time_s],
            [round(float(theta), 4) for theta in np.degrees(record.theta) + noise],
        )
        same = ("debonding", "kinematics", "block")
        known: dict[str, Any] = {"origin": "simulated", "model": TRUE} | {
            key: record.truth[key] for key in same
        }
        truth[name] = known | {"noise_deg": NOISE_DEG, "runs": record.truth["runs"]}
    folder.mkdir(parents=True, exist_ok=True)
    write_workbook(folder / FILE, pairs)
    write_truth(folder, truth)
    write_manifest(folder, [FILE, "truth.json"])


if __name__ == "__main__":
    write_campaign(*sys.argv[1:])
