"""Bad input: one line that tells what to do, an exit code, nothing half-written; the other records finish."""

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from small_campaign import CAMPAIGN, add_campaign, check_out, simulated

from freerock.files import sha256
from freerock.products.netcdf import open_record
from freerock.products.netcdf_groups import reasons_in
from freerock.runs.verdict import Reason
from freerock.virtual_lab.write_tdms import write_records, write_tdms

COPY = "copy it again from the acquisition computer"
CHECK = "check the channel, the cable and the sensor's range"
DECLARE = "declare it as units of the laser: V, mV, kV, mA, A, m, cm, mm, um, rad, mrad, deg"
BAD = {
    "missing": "no such file; put it there, or correct its name",
    "empty": f"the file is empty; {COPY}",
    "truncated": f"the file is truncated: its last segment is incomplete; {COPY}",
    "channel": "no channel 'laser_2'; its channels are laser; "
    "name one (of a campaign in the channel column of its CSV)",
    "several": "has the channels laser, laser_2; name one (of a campaign in the channel column of its CSV)",
    "no_unit": f"lasers: units: the channel states no unit; {DECLARE}",
    "kilograms": f"lasers: units: the channel's unit 'kg' is not known; name another channel, or {DECLARE}",
    "millimetres": "lasers: units: range_m scales volts or milliamperes, and the file states 'mm'; "
    "correct that unit, or name a laser without range_m",
    "nan": f"laser signal: no sample is a number; {CHECK}",
    "constant": f"laser signal: constant at 4.6 V; {CHECK}",
    "no_rate": "'laser' gives no sampling rate (wf_increment is absent); head the time as Time [s], state "
    "the rate in the file as fs in Hz, or give sampling_rate_hz",
    "saturated": f"laser signal: no sample within -0.1 to 10.1 V (100% error_level); {CHECK}",
    "overturned": "record: no release found: held at 29.09°, beyond the block's critical angle 26.57°, it "
    "overturns; check the block's height and width and the laser's position",
    "no_release": "record: nothing moves: the signal stays within 0.081°; check that the channel, its "
    "coupling (DC), the sign and the laser are those of this record",
    "replaced": "has the sha256 {found}, raw/bad/manifest.csv lists {listed}; restore the file; if the "
    "change is meant: python -m freerock.files raw/bad",
}
WAVEFORM = {"wf_increment": 1 / 2000, "wf_start_offset": 0.0, "unit_string": "V"}


def write_volts(path, properties, **channels):
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [ChannelObject("rocking", name, np.asarray(v, float), properties) for name, v in channels.items()]
        )


def write_bad_records(raw):
    good = simulated("squat", 1, rate_hz=2000.0)  # that of WAVEFORM
    samples, rest = good.time_s.size, good.volts[good.time_s < 1]
    write_records(raw, [("replaced", good)])
    listed = sha256(raw / "replaced.tdms")
    write_tdms(raw / "replaced.tdms", simulated("squat", 2))
    write_tdms(raw / "overturned.tdms", simulated("squat", 3, angle_deg=28, longest_s=2))
    for test in ("channel", "truncated"):
        write_tdms(raw / f"{test}.tdms", good)
    whole = (raw / "truncated.tdms").read_bytes()
    (raw / "truncated.tdms").write_bytes(whole[: len(whole) // 2])
    (raw / "empty.tdms").write_bytes(b"")
    write_volts(raw / "several.tdms", WAVEFORM, laser=good.volts, laser_2=good.volts)
    write_volts(raw / "no_unit.tdms", WAVEFORM | {"unit_string": ""}, laser=good.volts)
    write_volts(raw / "kilograms.tdms", WAVEFORM | {"unit_string": "kg"}, laser=good.volts)
    write_volts(raw / "millimetres.tdms", WAVEFORM | {"unit_string": "mm"}, laser=good.volts)
    write_volts(raw / "nan.tdms", WAVEFORM, laser=np.full(samples, np.nan))
    write_volts(raw / "constant.tdms", WAVEFORM, laser=np.full(samples, 4.6))
    write_volts(raw / "no_rate.tdms", {}, laser=good.volts)
    write_volts(raw / "saturated.tdms", WAVEFORM, laser=np.full(samples, 10.2))
    write_volts(raw / "no_release.tdms", WAVEFORM, laser=np.tile(rest, 5))
    return {"listed": listed, "found": sha256(raw / "replaced.tdms")}


@pytest.fixture(scope="module")
def bad(tmp_path_factory):
    """A campaign of bad records, each processed; and the checksums of the replaced one."""
    checkout = check_out(tmp_path_factory.mktemp("bad"))
    add_campaign(
        checkout, "bad", CAMPAIGN, [(test, "laser_2" * (test == "channel"), "squat") for test in BAD]
    )
    (checkout / "raw/bad").mkdir(parents=True)
    checksums = write_bad_records(checkout / "raw/bad")
    done = checkout.snakemake(*(f"results/bad/records/{test}.nc" for test in BAD))
    assert done.returncode == 0, done.stderr
    assert not checkout.partial_files()
    return checkout, checksums


@pytest.mark.parametrize("test", BAD)
def test_bad_record_is_told_in_one_line(bad, test):
    checkout, checksums = bad
    line = f"raw/bad/{test}.tdms: {BAD[test]}".replace("{found}", checksums["found"])
    line = line.replace("{listed}", checksums["listed"])
    product = open_record(checkout / f"results/bad/records/{test}.nc")
    assert product.attrs["verdict"] == "fail"
    assert reasons_in(product.attrs) == (Reason("fail", "not_processed", line),)
    assert not product.children
    assert ("theta" in product) == (test in ("overturned", "no_release"))
    log = checkout / f"results/bad/logs/record_{test}.log"
    assert line in log.read_text().splitlines()


@pytest.mark.parametrize(
    ("new", "key", "told"),
    [
        ("mas_kg: 5.84", "mas_kg", "unknown key; did you mean 'mass_kg'?"),
        ("mass_kg: -5.84", "mass_kg", "-5.84 is not greater than 0; give the mass in kilograms"),
        (
            "mass_kg: 5.84, release_angle_deg: 15",
            "release_angle_deg",
            "released at 15° the block overturns, its critical angle is 14.036°; "
            "correct the release angle, the height or the width",
        ),
    ],
)
def test_bad_configuration_is_told_before_anything_runs(tmp_path, new, key, told):
    checkout = check_out(tmp_path / "checkout")
    add_campaign(checkout, "lab", CAMPAIGN.replace("mass_kg: 5.84", new), [("one", "", "tall")])
    done = checkout.snakemake()
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == f"config/campaigns/lab.yaml:4: blocks.tall.{key}: {told}"
    assert "Traceback" not in done.stderr
    assert not (checkout / "results").exists()
