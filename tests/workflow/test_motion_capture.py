"""A campaign of c3d files: θ, x and z of a body from its markers, analysed by Snakemake."""

import math
import warnings

import c3d
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from small_campaign import BLOCKS, CAMPAIGN, add_campaign, check_out, simulated

from freerock.virtual_lab.truth import write_truth

pytestmark = pytest.mark.slow
BODY = "yz:P+Q+R+S"
LINE = f"tall_mat,tall.c3d,theta:{BODY},tall,mat,body,x:{BODY};z:{BODY}\n"
CORNERS = np.array([[-0.03, -0.13], [0.03, -0.13], [0.03, 0.13], [-0.03, 0.13]])  # m, about the centre
NOISE_MM = 0.02


def write_capture(path, time_s, theta, block):
    """Four markers of a block that turns about its corners, in mm; P is out of sight for a while."""
    noise, side = np.random.default_rng(8), np.where(theta < 0, -1, 1)
    half = block.width_m / 2
    arm_x, arm_z = -side * half, block.height_m / 2  # from the corner to the centre
    x = side * half + arm_x * np.cos(theta) + arm_z * np.sin(theta)
    z = -arm_x * np.sin(theta) + arm_z * np.cos(theta)
    writer = c3d.Writer(point_rate=1 / (time_s[1] - time_s[0]))
    for i, (angle, here) in enumerate(zip(theta, np.column_stack([x, z]), strict=True)):
        c, s = math.cos(angle), math.sin(angle)
        rows = np.zeros((4, 5), np.float32)
        rows[:, 0] = 1200
        rows[:, 1:3] = 1000 * (here + CORNERS @ [[c, -s], [s, c]]) + noise.normal(0, NOISE_MM, (4, 2))
        if 300 < i < 320:
            rows[0, 3:] = -1
        writer.add_frames([(rows, np.zeros((0, 1)))])
    writer.set_point_labels(["P", "Q", "R", "S"])
    with open(path, "wb") as file, warnings.catch_warnings(action="ignore"):  # of no analog channels
        writer.write(file)


def test_a_c3d_file_is_a_record(tmp_path):
    checkout = check_out(tmp_path)
    yaml = CAMPAIGN.replace("lasers:\n", "lasers:\n  body: {units: rad}\n")
    add_campaign(checkout, "captured", yaml, [])
    (checkout / "config/campaigns/captured.csv").write_text(
        "test,file,channel,block,foundation,laser,position\n" + LINE
    )
    record = simulated("tall", 3)
    raw = checkout / "raw/captured"
    raw.mkdir(parents=True)
    write_capture(raw / "tall.c3d", record.time_s, record.theta, BLOCKS["tall"][0])
    write_truth(raw, {"tall_mat": record.truth})
    done = checkout.snakemake()
    assert done.returncode == 0, done.stderr
    found = xr.load_datatree(checkout / "results/captured/records/tall_mat.nc", engine="netcdf4")
    whole = found.to_dataset() if "theta" in found else next(iter(found.children.values())).to_dataset()
    theta = whole["theta"].values
    sigma = NOISE_MM / 1000 / math.sqrt((CORNERS**2).sum())
    error = (theta - record.theta)[np.isfinite(theta)]
    assert error.size > 0.99 * theta.size
    assert error.std() < 1.1 * sigma and abs(error.mean()) < sigma
    np.testing.assert_allclose(whole["position_z"][:100], 0.14, atol=5 * NOISE_MM / 1000)
    runs = pd.read_csv(checkout / "results/captured/tables/runs.csv")
    assert len(runs) == 1 and runs["verdict"][0] != "fail", runs.T
    choice = pd.read_csv(checkout / "results/captured/tables/choice.csv")
    assert (choice.loc[choice["status"] == "selected", "model"] == "hunt_crossley").all()

    csv = checkout / "config/campaigns/captured.csv"
    csv.write_text(csv.read_text().replace("theta:yz:P+Q", "theta:yz:P+T"))
    done = checkout.snakemake("results/captured/records/tall_mat.nc")
    assert done.returncode == 0 and "Traceback" not in done.stderr
    line = (checkout / "results/captured/logs/record_tall_mat.log").read_text().splitlines()[-1]
    assert "raw/captured/tall.c3d: no marker 'T'; its markers are P, Q, R, S; correct the channel" in line
