"""Bad input: one line that tells what to do, an exit code, nothing half-written; the other records finish."""

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from small_campaign import CAMPAIGN, add_campaign, check_out, simulated

from freerock import twin

WAVEFORM = {"wf_increment": 1 / 2000, "wf_start_offset": 0.0, "unit_string": "V"}


def write_volts(path, volts, **properties):
    with TdmsWriter(path) as writer:
        writer.write_segment([ChannelObject("rocking", "laser", np.asarray(volts, float), properties)])


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    """A campaign of one good record and one of each bad kind, after a run; and what the run said."""
    checkout = check_out(tmp_path_factory.mktemp("bad"))
    tests = ["good", "missing", "truncated", "empty", "channel", "nan", "constant", "no_rate", "saturated"]
    tests += ["overturned", "no_release", "replaced"]
    records = [(test, "laser_2" if test == "channel" else "", "squat") for test in tests]
    add_campaign(checkout, "small", CAMPAIGN.replace("truth: truth.json\n", ""), records)

    good, raw = simulated("squat", 1), checkout / "raw/small"
    twin.write_campaign(raw, [("good", good), ("replaced", good)])
    twin.write_record(raw / "replaced.tdms", simulated("squat", 2))
    twin.write_record(raw / "channel.tdms", good)
    twin.write_record(raw / "truncated.tdms", good)
    whole = (raw / "truncated.tdms").read_bytes()
    (raw / "truncated.tdms").write_bytes(whole[: len(whole) // 2])
    (raw / "empty.tdms").write_bytes(b"")
    write_volts(raw / "nan.tdms", np.full(good.volts.size, np.nan), **WAVEFORM)
    write_volts(raw / "constant.tdms", np.full(good.volts.size, 4.6), **WAVEFORM)
    write_volts(raw / "no_rate.tdms", good.volts)
    write_volts(raw / "saturated.tdms", np.full(good.volts.size, 10.2), **WAVEFORM)
    rest = good.volts[good.time_s < 1.0]
    write_volts(raw / "no_release.tdms", np.tile(rest, 5), **WAVEFORM)
    return checkout, checkout.snakemake()


def reported(analysed):
    checkout, done = analysed
    return [line for line in done.stderr.splitlines() if line.startswith("small: record ")]


def test_show(analysed):
    checkout, done = analysed
    print(done.returncode)
    print("\n".join(reported(analysed)))
    print(done.stderr[-6000:])
    print((checkout / "results/small/tables/runs.csv").read_text())
