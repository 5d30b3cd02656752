"""Whether a campaign is ready: its configuration, record files, channels, calibrations, checksums, units.

example:
  freerock check palermo_virtual

Lists every mistake of the configuration, and each record file, channel, unit, calibration and
checksum that contradicts it. Improbable values, such as angles in radians or time in milliseconds,
are printed as doubts. Doubts do not change the exit code. Nothing is written. Each run of snakemake
prints those doubts for which no samples need to be read.
"""

import math
import re
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from freerock.config.campaign import Campaign, Source, campaign_paths, read_campaign
from freerock.config.keys_of_blocks import BlockSection, density_if_square
from freerock.config.keys_of_lasers import LaserSection
from freerock.config.mistakes import refuse
from freerock.config.record import Record
from freerock.config.step_settings import section_values
from freerock.errors import FreerockError, attempt
from freerock.files import MANIFEST, check_manifest, listed_checksums, regular
from freerock.units import in_base_units
from freerock.virtual_lab.truth import read_truth

if TYPE_CHECKING:
    from freerock.arrays import Floats
    from freerock.records.channels import Named
    from freerock.rotation.calibration import Calibration
    from freerock.rotation.sensor import Laser

    Contents = Named | FreerockError
    Tables = dict[str, Calibration]


# What records of free rocking lie well within, set on the two campaigns that come with the project, 15
# records of 12 blocks: their signals sweep 0.93 to 1.25 of the critical angle, have 23 to 340 samples in
# 1/p, the time scale of the rocking block, and last 56/p or longer; none of their samples is outside the
# declared output; the blocks have 120 to 2200 kg/m³. A wrong unit is off by a factor of 57, 100 or 1000.
LEAST_ANGLE, MOST_ANGLE = 0.04, 4.0  # swept, of the critical angle; the least also of a release angle
LEAST_NOMINAL, MOST_NOMINAL = 0.3, 5.0  # swept, of the release angle in the configuration
LEAST_SAMPLES, LEAST_LENGTH = 8.0, 5.0  # of a record: samples in 1/p, length in 1/p
MOST_BEYOND = 2e-3  # share of the samples outside the declared output of the sensor
LIGHTEST, DENSEST = 5.0, 5e4  # density of the block, were it as deep as it is high [kg/m³]
EARTH = (9.76, 9.84)  # gravity [m/s²], from high on the equator to the poles
MOST_WORK = 1e9  # bytes of record files that a check reads: some seconds
SLOWER = {".xlsx": 100, ".xlsm": 100, ".csv": 10, ".tsv": 10, ".txt": 10, ".lvm": 10}  # to read, by the byte
SIMULATED, HEAD = re.compile(rb"\bsimulated\b", re.IGNORECASE), 1 << 16  # of a file's title; its first bytes
LEAD_S = 0.5  # of motion before the first phase of stillness: a record that begins in motion
HELD_BEYOND = "check the settings of the laser and the block's size"
NAME_IT = "name one in the channel column of the campaign's CSV"


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add(
        "campaign",
        metavar="CAMPAIGN",
        nargs="?",
        help="its name or YAML file; by default the campaigns of config/config.yaml",
    )


def run(chosen: Namespace) -> None:
    """Print doubts and what is sound; raise all problems together."""
    sound, problems, doubts = check_config(campaign=chosen.campaign)
    for doubt in doubts:
        print(f"doubt: {doubt}")
    for line in sound:
        print(f"{line}: nothing to correct{', but see the doubts' if doubts else ''}")
    refuse(problems)


def check_config(
    path: str | Path = "config/config.yaml", campaign: str | None = None
) -> tuple[list[str], list[FreerockError], list[FreerockError]]:
    """Check the campaigns of a configuration, or one of them.

    Parameters
    ----------
    path : path
        The configuration file; campaigns lie in the folder `campaigns` beside it.
    campaign : str, optional
        Name of the one campaign, or path of its YAML file.

    Returns
    -------
    sound : list of str
        A line for each campaign without a problem.
    problems : list of FreerockError
        All problems of all files.
    doubts : list of FreerockError
        What is possible and unusual in the campaigns without a problem.
    """
    problems: list[FreerockError] = []
    doubts: list[FreerockError] = []
    if campaign is not None and campaign.endswith((".yaml", ".yml")):
        paths = [Path(campaign)]
    else:
        paths = campaign_paths(path, None if campaign is None else [campaign], problems)
    sound = []
    for each in paths:
        source = read_campaign(each)
        found = [*source.problems, *(check_files(source) if each.exists() else ())]
        asked = [] if found else [*configuration_doubts(source), *signal_doubts(source, found)]
        problems += found
        if not found and source.campaign:
            held = {"record": source.records, "block": source.campaign.blocks}
            held |= {"foundation": source.campaign.foundations}
            counted = (f"{len(all_of)} {what}{'s' * (len(all_of) != 1)}" for what, all_of in held.items())
            sound.append(f"{each.stem}: {', '.join(counted)}")
            doubts += asked
    return sound, problems, doubts


def check_files(source: Source) -> Iterator[FreerockError]:
    """Problems of the files that a campaign names, and of its manifest."""
    if not Path(source.raw).is_dir():
        yield FreerockError(source.where("raw"), f"there is no folder {source.raw}", "put the records there")
        return
    from freerock.records.read import list_channels
    from freerock.rotation.calibration import read_calibration

    tables: Tables = {}
    unread: set[str] = set()  # files of which a problem says so
    for name, laser in source.lasers.items():
        if laser.calibration:
            table = attempt(read_calibration, Path(source.raw, laser.calibration))
            if isinstance(table, FreerockError):
                unread.add(laser.calibration)
                yield _at(source.where("lasers", name, "calibration"), table)
            else:
                tables[name] = table
    if source.campaign and source.campaign.truth:
        truth = attempt(read_truth, Path(source.raw, source.campaign.truth))
        if isinstance(truth, FreerockError):
            unread.add(source.campaign.truth)
            yield _at(source.where("truth"), truth)
    csv = source.path.with_suffix(".csv")
    contents: dict[Path, Contents] = {}
    for line, record in source.records:
        path = Path(source.raw, record.file)
        if path not in contents:
            contents[path] = attempt(list_channels, path)
        if isinstance(contents[path], FreerockError):
            unread.add(record.file)
        yield from _record(f"{csv}:{line}", source, contents[path], record, tables)
    yield from _manifest(source.raw, unread)


def _manifest(raw: str, unread: set[str]) -> Iterator[FreerockError]:
    """Files that are not those listed, but for those already named as unreadable."""
    listed = attempt(listed_checksums, raw)
    files = [] if isinstance(listed, FreerockError) else [file for file in listed if file not in unread]
    found = [listed, *(attempt(check_manifest, raw, [file]) for file in files)]
    yield from (each for each in found if isinstance(each, FreerockError))


def _record(
    where: str, source: Source, contents: "Contents", record: Record, tables: "Tables"
) -> Iterator[FreerockError]:
    from freerock.records.channels import chosen, names_in_short

    path = Path(source.raw, record.file)
    if isinstance(contents, FreerockError):
        yield _at(f"{where}: file", contents)
        return
    for channel, name in zip(record.channels, record.lasers, strict=False):
        found = attempt(chosen, path, contents, channel or None)
        if isinstance(found, FreerockError):
            yield _at(f"{where}: channel", found)
        elif len(found) > 1:
            yield FreerockError(
                f"{where}: channel", f"{path}: has the channels {names_in_short(found)}", NAME_IT
            )
        elif name in source.lasers:
            (unit,) = (each.units for each in found.values())
            yield from _unit(f"{where}: laser", unit, source.lasers[name], tables.get(name))


def _unit(
    where: str, stated: str, laser: LaserSection, table: "Calibration | None"
) -> Iterator[FreerockError]:
    found = attempt(in_base_units, [], laser.units, stated)
    if isinstance(found, FreerockError):
        yield _at(where, found)
        return
    if (quantity := found[1]) not in ("voltage", "current"):
        return
    if not (laser.range_m or laser.sensitivity_per_mm or laser.calibration):
        remedy = "give one of range_m, sensitivity_per_mm, calibration to the laser"
        yield FreerockError(where, f"a {quantity} has no scale", remedy)
    if table and table.quantity != quantity:
        what = f"the calibration table is of a {table.quantity}, the channel of a {quantity}"
        yield FreerockError(where, what, "give the table of this sensor")


def _at(where: str, error: FreerockError) -> FreerockError:
    return FreerockError(where, f"{error.where}: {error.what}", error.remedy)


def configuration_doubts(source: Source) -> Iterator[FreerockError]:
    """What the user should look at again in the configuration, for which no samples need to be read.

    No doubt stops an analysis. Each run of the workflow prints these.
    """
    campaign = source.campaign
    if campaign is None:
        return
    for name, block in campaign.blocks.items():
        planned = campaign.plan.release_angles_deg.get(name, ()) if campaign.plan else ()
        yield from _block(source.where("blocks", name), block, planned)
    for name, foundation in campaign.foundations.items():
        if campaign.origin == "measured" and foundation.levelled_deg is None:
            what = "has no levelled_deg, and a tilt of a tenth of a degree changes k"
            remedy = "level its base in the plane of rocking, and state levelled_deg"
            yield FreerockError(source.where("foundations", name), what, remedy)
    csv = source.path.with_suffix(".csv")
    yield from _heads(csv, source, campaign)
    yield from _unnamed(csv, source, campaign)
    yield from _same_signal(csv, source)


def signal_doubts(source: Source, problems: list[FreerockError]) -> Iterator[FreerockError]:
    """What the user should look at again in the records, which takes some seconds to read.

    Why a record can't be read is appended to `problems`.
    """
    campaign, csv, work = source.campaign, source.path.with_suffix(".csv"), 0.0
    if campaign is None:
        return
    for number, (line, record) in enumerate(source.records):
        path = Path(source.raw, record.file)
        work += path.stat().st_size * SLOWER.get(path.suffix.lower(), 1)
        if work > MOST_WORK:
            what = f"only {number} of {len(source.records)} records were looked into"
            yield FreerockError(csv, what, "look into the others with freerock inspect")
            return
        try:
            for channel, laser in zip(record.channels, record.lasers, strict=True):
                yield from _channel(f"{csv}:{line}: {record.test}", campaign, record, channel, laser)
            yield from _by_hand(f"{csv}:{line}", path, record)
        except FreerockError as error:
            if not record.excluded:
                problems.append(_at(f"{csv}:{line}: file", error))


def _heads(csv: Path, source: Source, campaign: Campaign) -> Iterator[FreerockError]:
    """Records that have no file, and those of a measured campaign whose file says at its head "simulated"."""
    for line, record in source.records:
        path, where = Path(source.raw, record.file), f"{csv}:{line}: {record.test}"
        if not path.exists():
            if not record.excluded:
                yield FreerockError(where, f"there is no file {path}", "put it there, or the record fails")
        elif campaign.origin == "measured" and SIMULATED.search(_head(path)):
            what = f"{path} calls itself simulated, and the campaign says origin: measured"
            yield FreerockError(where, what, "state origin: simulated, or name the measured file")


def _head(path: Path) -> bytes:
    """The first bytes of a file, among which are title and description; none where it can't be read."""
    try:
        with open(path, "rb", opener=regular) as file:
            return file.read(HEAD)
    except OSError:
        return b""


def _same_signal(csv: Path, source: Source) -> Iterator[FreerockError]:
    """Records whose signal is that of another record."""
    first: dict[tuple[str, str], str] = {}
    for line, record in source.records:
        for channel in record.channels:
            test = first.setdefault((record.file, channel), record.test)
            if test != record.test:
                named = f", channel {channel}," if channel else ""
                what = f"{record.file}{named} is the signal of {test} too"
                where = f"{csv}:{line}: {record.test}"
                yield FreerockError(where, what, "name the file and channel of this record")


def _unnamed(csv: Path, source: Source, campaign: Campaign) -> Iterator[FreerockError]:
    """Record files that the manifest lists and no line names; calibrations and the truth are no records."""
    named = {record.file for _, record in source.records}
    kinds = {Path(file).suffix for file in named}
    beside = {campaign.truth, *(laser.calibration for laser in campaign.lasers.values())}
    for file in listed_checksums(source.raw):
        if Path(file).suffix in kinds and file not in named | beside:
            what = f"no line names {file}, which {Path(source.raw, MANIFEST)} lists"
            yield FreerockError(csv, what, "add a line for it, or take it out of the manifest")


def _block(where: str, block: BlockSection, planned: Iterable[float]) -> Iterator[FreerockError]:
    """Doubts about one block, its release angle and those of the plan."""
    critical = math.degrees(block.block.theta_cr)
    density = density_if_square(block.height_m, block.width_m, block.mass_kg)
    if not LIGHTEST < density < DENSEST:
        what = f"as deep as it is high, the block would have {density:.3g} kg/m³"
        yield FreerockError(where, what, "give height_m and width_m in metres, mass_kg in kilograms")
    gravity = block.block.g
    if not EARTH[0] <= gravity <= EARTH[1]:
        what = f"gravity_m_s2 is {gravity:g}, on Earth {EARTH[0]} to {EARTH[1]} m/s²"
        yield FreerockError(where, what, "give it in m/s²")
    for angle in filter(None, {block.release_angle_deg, *planned}):
        if angle < LEAST_ANGLE * critical:
            share = f"{100 * angle / critical:.2g} % of the critical angle"
            turned = math.degrees(angle)
            what = f"a release angle of {angle:g}° is {share}, in radians it would be {turned:.3g}°"
            yield FreerockError(where, what, "give it in degrees")


def _channel(
    where: str, campaign: Campaign, record: Record, channel: str, name: str
) -> Iterator[FreerockError]:
    """Doubts about the rate, the length and the size of one channel of a record, and how its runs begin."""
    import numpy as np

    from freerock.records.read import read_record
    from freerock.rotation.sensor import laser_of, looks_like_current

    block, laser = campaign.blocks[record.block], campaign.lasers[name]
    read = read_record(campaign.file(record.test), channel or None)
    (signal,) = read.data_vars.values()
    sensor = laser_of(section_values(laser, "uncertainty"), campaign.raw)
    values, quantity = in_base_units(signal.values, laser.units, str(signal.attrs["units"]))
    swept_deg = partial(_swept_deg, quantity=quantity, sensor=sensor, block=block)
    swept = swept_deg(values)
    if quantity == "voltage" and looks_like_current(values, sensor):
        seen = values[np.isfinite(values)]
        what = f"the signal, {seen.min():.3g} to {seen.max():.3g} V, looks like mA"
        yield FreerockError(where, what, "declare units: mA of the laser, or name its channel")
        return
    found = [*_beyond_output(where, values, quantity, sensor)]
    rate, p = float(read.attrs["sampling_rate_hz"]), block.block.p
    critical, nominal = math.degrees(block.block.theta_cr), block.release_angle_deg
    unit = "is the unit of time right?"
    if rate < LEAST_SAMPLES * p:
        what = f"{rate:.4g} Hz are {rate / p:.2g} samples in 1/p = {1 / p:.2g} s, the block's time scale"
        found.append(FreerockError(where, what, unit))
    if signal.size / rate < LEAST_LENGTH / p:
        what = f"the record lasts {signal.size / rate:.2g} s, a swing of the block about {2 / p:.2g} s"
        found.append(FreerockError(where, what, unit))
    if not LEAST_ANGLE * critical < swept < MOST_ANGLE * critical:
        what = f"the signal sweeps {swept:.3g}°, the critical angle is {critical:.3g}°"
        found.append(FreerockError(where, what, "are its unit and the laser's scale right?"))
    elif nominal and not LEAST_NOMINAL * nominal < swept < MOST_NOMINAL * nominal:
        what = f"the signal sweeps {swept:.3g}°, the block's release_angle_deg is {nominal:g}"
        found.append(FreerockError(where, what, "is that in degrees, and the unit of the channel right?"))
    if not (found or record.excluded or record.override):
        window_s = campaign.processing.runs.window_s
        found += _holds(where, read["time"].values, values, window_s, swept_deg, critical)
    yield from found


def _holds(
    where: str,
    time_s: "Floats",
    values: "Floats",
    window_s: float,
    swept_deg: "Callable[[Floats], float]",
    critical: float,
) -> Iterator[FreerockError]:
    """A doubt where no hold is followed by free rocking to rest, or one is beyond the critical angle [°]."""
    import numpy as np

    from freerock.rotation.still import UNSTEADY, stationary_phases

    found = phases = stationary_phases(time_s, values, window_s=window_s)
    if all(phase.kind != "held" for phase in phases):
        found = stationary_phases(time_s, values, window_s=window_s, floor_fraction=UNSTEADY)
    levels = [phase.level for phase in found if phase.kind == "held"]
    if levels:
        zero = next(phase.level for phase in found if phase.kind == "rest")
        angle = max(swept_deg(np.array([zero, level])) for level in levels)
        if angle > critical:
            what = f"the block is held at about {angle:.3g}°, beyond its critical angle of {critical:.3g}°"
            yield FreerockError(where, what, HELD_BEYOND)
    elif phases and phases[0].start_s > time_s[0] + LEAD_S:
        what = "begins in motion: nothing stands still before it rocks to rest"
        remedy = "set the release by hand (column override), or name the channel that is meant"
        yield FreerockError(where, what, remedy)
    else:
        what = "no phase of stillness is followed by free rocking to rest"
        yield FreerockError(where, what, "name the channel that is meant")


def _beyond_output(where: str, values: "Floats", quantity: str, sensor: "Laser") -> Iterator[FreerockError]:
    """Doubts about samples outside the declared output, which no analysis uses."""
    import numpy as np

    from freerock.rotation.sensor import SEVERAL_LEVELS

    limits = sensor.limits(quantity)
    if not limits:
        return
    name, suffix, unit = ("volts", "v", "V") if quantity == "voltage" else ("milliamps", "ma", "mA")
    values = values[np.isfinite(values) & (np.abs(values - limits.error_level) > limits.error_tolerance)]
    for side, far, limit, beyond, keys in (
        ("below", "down", limits.low, values[values < limits.low], f"{name}_at_start, valid_low_{suffix}"),
        ("above", "up", limits.high, values[values > limits.high], f"{name}_at_end, valid_high_{suffix}"),
    ):
        if beyond.size > MOST_BEYOND * values.size:
            share, farthest = 100 * beyond.size / values.size, max(beyond, key=abs)
            what = f"{share:.3g} % of the samples lie {side} {limit:g} {unit}, {far} to {farthest:.3g} {unit}"
            one_level = np.ptp(beyond) < SEVERAL_LEVELS
            remedy = f"if that means no target give error_level_{suffix}, else " if one_level else ""
            yield FreerockError(where, what, f"{remedy}correct {keys} of the laser")


def _by_hand(where: str, path: Path, record: Record) -> Iterator[FreerockError]:
    """Doubts about what is set by hand: it ends within the record."""
    from freerock.records.read import read_record

    if not record.overrides and not record.stretches:
        return
    end_s = float(read_record(path, record.channels[0] or None)["time"][-1])
    ends = [("override", f"run {number}", run_end_s) for number, _, run_end_s, *_ in record.overrides]
    ends += [("exclude", "it", to_s) for _, to_s, _ in record.stretches]
    for column, what, last_s in ends:
        if last_s > end_s:
            what = f"{what} ends at {last_s:g} s, the record at {end_s:.3f} s"
            yield FreerockError(f"{where}: {column}", what, "give times within the record")


def _swept_deg(values: "Floats", quantity: str, sensor: "Laser", block: BlockSection) -> float:
    """About what angle a signal sweeps [°], but for a thousandth of its samples at either end."""
    import numpy as np

    from freerock.rotation.sensor import distance_from_output

    if limits := sensor.limits(quantity):
        values = values[(values >= limits.low) & (values <= limits.high)]
    distance, _ = distance_from_output(values, sensor, quantity)
    distance = distance[np.isfinite(distance)]
    if not distance.size:
        return 0.0
    low, high = np.quantile(distance, [0.001, 0.999])
    if quantity == "rotation":
        return math.degrees(high - low)
    half = block.width_m / 2
    lever = sensor.position if sensor.beam == "horizontal" else half + abs(sensor.position)
    return math.degrees(math.atan((high - low) / lever))
