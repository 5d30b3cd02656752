"""Whether a campaign is ready: its configuration, record files, channels, calibrations, checksums, units.

example:
  freerock check palermo_virtual

Lists every mistake of the configuration, and each record file, channel, unit, calibration and
checksum that contradicts it. Every file that can be read is read whole. Improbable values, such as
angles in radians or time in milliseconds, are printed as doubts. Doubts do not change the exit code.
Nothing is written.
"""

import math
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from freerock.config.blocks import BlockSection
from freerock.config.campaign import Campaign, Source, campaign_paths, read_campaign
from freerock.config.lasers import LaserSection
from freerock.config.mistakes import refuse
from freerock.config.record import Record
from freerock.config.step_settings import section_values
from freerock.errors import FreerockError, attempt, number_of
from freerock.files import check_file, listed_checksums, sha256
from freerock.models.block import density_if_square

if TYPE_CHECKING:
    from freerock.arrays import Floats
    from freerock.records.channels import Named
    from freerock.rotation.sensor import Calibration, Laser

    Contents = Named | FreerockError
    Tables = dict[str, Calibration]


# What records of free rocking lie well within; a wrong unit is off by a factor of 57, 100 or 1000.
LEAST_ANGLE, MOST_ANGLE = 0.04, 4.0  # swept, of the critical angle; the least also of a release angle
LEAST_NOMINAL, MOST_NOMINAL = 0.3, 5.0  # swept, of the release angle in the configuration
LEAST_SAMPLES, LEAST_LENGTH = 8.0, 5.0  # of a record: samples in 1/p, length in 1/p
LIGHTEST, DENSEST = 5.0, 5e4  # density of the block, were it as deep as it is high [kg/m³]
EARTH = (9.76, 9.84)  # gravity [m/s²], from high on the equator to the poles


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN", nargs="?", help="by default those of config/config.yaml")


def run(chosen: Namespace) -> None:
    """Print doubts and what is sound; raise all problems together."""
    sound, problems, doubts = check_config(campaign=chosen.campaign)
    for path in campaign_paths("config/config.yaml", chosen.campaign and [Path(chosen.campaign).stem], []):
        for note in left_unread(read_campaign(path)):
            print(f"not read: {note}")
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
        Name of the one campaign, or path of its YAML file there.

    Returns
    -------
    sound : list of str
        A line for each campaign without a problem.
    problems : list of FreerockError
        All problems of all files.
    doubts : list of FreerockError
        What is possible and unusual.
    """
    sound, problems, doubts = list[str](), list[FreerockError](), list[FreerockError]()
    for each in campaign_paths(path, campaign and [Path(campaign).stem], problems):
        source = read_campaign(each)
        found, asked = check_files(source) if source.lines else ([], [])
        found = [*source.problems, *found]
        problems += found
        doubts += [*configuration_doubts(source), *asked]
        if not found:
            sound.append(f"{each.stem}: {number_of(len(source.records), 'record')}")
    return sound, problems, doubts


def check_files(source: Source) -> tuple[list[FreerockError], list[FreerockError]]:
    """Problems of the files that a campaign names and of its manifest; what its records make doubtful."""
    if not Path(source.raw).is_dir():
        what = f"there is no folder {source.raw}"
        return [FreerockError(source.where("raw"), what, "put the records there")], []
    from freerock.records.read import list_channels
    from freerock.rotation.sensor import read_calibration

    problems, doubts = list[FreerockError](), list[FreerockError]()
    tables: Tables = {}
    unread: set[str] = set()  # files of which a problem says so
    for name, laser in source.lasers.items():
        if laser.calibration:
            table = attempt(read_calibration, Path(source.raw, laser.calibration))
            if isinstance(table, FreerockError):
                unread.add(laser.calibration)
                problems.append(_at(source.where("lasers", name, "calibration"), table))
            else:
                tables[name] = table
    csv = source.path.with_suffix(".csv")
    contents: dict[Path, Contents] = {}
    for line, record in source.records:
        path = Path(source.raw, record.file)
        if path not in contents:
            contents[path] = attempt(list_channels, path)
        if isinstance(contents[path], FreerockError):
            unread.add(record.file)
        found = [*_record(f"{csv}:{line}", source, contents[path], record, tables)]
        problems += found
        untold = {name for name, laser in source.lasers.items() if laser.calibration and name not in tables}
        if not (found or untold & {*record.lasers} or isinstance(contents[path], FreerockError)):
            doubts += _signals(f"{csv}:{line}", source, record, problems)
    return [*problems, *_manifest(source.raw, unread)], doubts


def _manifest(raw: str, unread: set[str]) -> Iterator[FreerockError]:
    """Files that are not those listed, but for those already named as unreadable."""
    listed = attempt(listed_checksums, raw)
    if isinstance(listed, FreerockError):
        yield listed
        return
    found = (attempt(check_file, raw, file, listed[file]) for file in listed if file not in unread)
    yield from filter(None, found)


def _record(
    where: str, source: Source, contents: "Contents", record: Record, tables: "Tables"
) -> Iterator[FreerockError]:
    from freerock.records.channels import NAME_ONE, chosen, names_in_short

    path = Path(source.raw, record.file)
    if isinstance(contents, FreerockError):
        if not (record.excluded and path.is_file()):
            yield _at(f"{where}: file", contents)
        return
    for channel, name in zip(record.channels, record.lasers, strict=False):
        found = attempt(chosen, path, contents, channel or None)
        if isinstance(found, FreerockError):
            yield _at(f"{where}: channel", found)
        elif len(found) > 1:
            yield FreerockError(
                f"{where}: channel", f"{path}: has the channels {names_in_short(found)}", NAME_ONE
            )
        elif name in source.lasers:
            (unit,) = (each.units for each in found.values())
            yield from _unit(f"{where}: laser", unit, source.lasers[name], tables.get(name))


def _unit(
    where: str, stated: str, laser: LaserSection, table: "Calibration | None"
) -> Iterator[FreerockError]:
    from freerock.rotation.sensor import recorded_of

    found = attempt(recorded_of, [], laser, stated)
    if isinstance(found, FreerockError):
        yield FreerockError(where, found.what, found.remedy)
        return
    quantity = found[1]
    if table and quantity in ("voltage", "current") and table.quantity != quantity:
        what = f"the calibration table is of a {table.quantity}, the channel of a {quantity}"
        yield FreerockError(where, what, "give the table of this sensor")


def _at(where: str, error: FreerockError) -> FreerockError:
    return FreerockError(where, f"{error.where}: {error.what}", error.remedy)


def configuration_doubts(source: Source) -> Iterator[FreerockError]:
    """What the user should look at again in the configuration, for which no samples need to be read.

    No doubt stops an analysis.
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
    yield from _same_signal(source.path.with_suffix(".csv"), source)


def _signals(
    line: str, source: Source, record: Record, problems: list[FreerockError]
) -> Iterator[FreerockError]:
    """What the user should look at again in a record; why it can't be analysed is added to `problems`."""
    campaign = source.campaign
    if campaign is None or record.block not in campaign.blocks or {*record.lasers} - {*campaign.lasers}:
        return
    for channel, laser in zip(record.channels, record.lasers, strict=True):
        found = attempt(_channel, f"{line}: {record.test}", campaign, record, channel, laser)
        if isinstance(found, FreerockError):
            path = f"{campaign.raw}/{record.file}"
            at = found.where if path in str(found.where) else f"{path}: {found.where}"
            problem = FreerockError(f"{line}: file", f"{at}: {found.what}", found.remedy)
            problems += [] if record.excluded else [problem]
        else:
            yield from found


def _same_signal(csv: Path, source: Source) -> Iterator[FreerockError]:
    """Records whose signal is that of another record, in the same file or in a copy: it would count twice."""
    listed, first = attempt(listed_checksums, source.raw), dict[tuple[str, str], Record]()
    known = {} if isinstance(listed, FreerockError) else listed
    for line, record in source.records:
        if record.file not in known and (path := Path(source.raw, record.file)).is_file():
            known[record.file] = sha256(path)
        for channel in record.channels:
            other = first.setdefault((known.get(record.file, record.file), channel), record)
            if other.test.casefold() != record.test.casefold():  # else it is a mistake already
                what = f"{record.file} holds the signal of {other.test} too"
                remedy = f"name its own file and channel, or exclude {record.test} or {other.test}"
                yield FreerockError(f"{csv}:{line}: {record.test}", what, remedy)


def left_unread(source: Source) -> Iterator[str]:
    """What the record files of a campaign hold beside channels: columns left out, rows above the numbers."""
    from freerock.records.read import list_channels

    for file in dict.fromkeys(record.file for _, record in source.records):
        found = attempt(list_channels, path := Path(source.raw, file))
        if not isinstance(found, FreerockError):
            yield from (f"{path}: {name} {c.fault}" for name, c in found.items() if c.fault)
            yield from (f"{path}: {row}" for row in found.above)


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


def _channel(where: str, campaign: Campaign, record: Record, channel: str, name: str) -> list[FreerockError]:
    """Doubts about the rate, the length and the size of one channel of a record."""
    from freerock.records.read import read_record
    from freerock.rotation.channel import flagged
    from freerock.rotation.sensor import laser_of, recorded_of

    block, laser = campaign.blocks[record.block], campaign.lasers[name]
    known, path = campaign.processing.rotation, f"{campaign.raw}/{record.file}"
    read = read_record(path, channel or None, time_unit=known.time_unit, rate_hz=known.sampling_rate_hz)
    (signal,) = read.data_vars.values()
    rate, p = float(read.attrs["sampling_rate_hz"]), block.block.p
    sensor = laser_of(section_values(laser, "uncertainty"), campaign.raw)
    values, quantity = recorded_of(signal.values, sensor, str(signal.attrs["units"]))
    flagged(values, 1 / rate, sensor, quantity)
    swept, doubts = _swept_deg(values, quantity, sensor, block), list[tuple[str, str]]()
    critical, nominal = math.degrees(block.block.theta_cr), block.release_angle_deg
    unit = "is the unit of time right?"
    if rate < LEAST_SAMPLES * p:
        what = f"{rate:.4g} Hz are {rate / p:.2g} samples in 1/p = {1 / p:.2g} s, the block's time scale"
        doubts.append((what, unit))
    if signal.size / rate < LEAST_LENGTH / p:
        what = f"the record lasts {signal.size / rate:.2g} s, a swing of the block about {2 / p:.2g} s"
        doubts.append((what, unit))
    if not LEAST_ANGLE * critical < swept < MOST_ANGLE * critical:
        what = f"the signal sweeps {swept:.3g}°, the critical angle is {critical:.3g}°"
        doubts.append((what, "are its unit and the laser's scale right?"))
    elif nominal and not LEAST_NOMINAL * nominal < swept < MOST_NOMINAL * nominal:
        what = f"the signal sweeps {swept:.3g}°, the block's release_angle_deg is {nominal:g}"
        doubts.append((what, "is that in degrees, and the unit of the channel right?"))
    return [FreerockError(where, *doubt) for doubt in doubts]


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
