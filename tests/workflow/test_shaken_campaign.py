"""Ground motions of a campaign: batches, fragility, report; a batch lost or killed, a motion that is none."""

import os
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from golden_numbers import differences
from small_campaign import ROOT

from freerock.config.campaign import load_campaign
from freerock.jobs import supplement
from freerock.jobs.code_identity import code

pytestmark = pytest.mark.slow
MOTIONS = "ground_motions: {folder: raw/ground, scales: [0.6, 1.2, 2.0], draws: 3, motions_per_job: 2}\n"


def add_motions(checkout, n=5):
    """Sines of a band under an envelope, as tables [g]."""
    folder = checkout / "raw/ground"
    folder.mkdir()
    t = np.arange(0, 8, 0.01)
    for i in range(n):
        draw = np.random.default_rng(i)
        waves = [np.sin(2 * np.pi * (f * t + phase)) for f, phase in draw.uniform(0.5, 3.0, (8, 2))]
        a = np.sum(waves, axis=0) * np.exp(-(((t - 3) / 2) ** 2))
        rows = zip(t, 0.35 * a / np.abs(a).max(), strict=True)
        text = "time [s],acceleration [g]\n" + "".join(f"{at:.2f},{value:.6f}\n" for at, value in rows)
        (folder / f"motion_{i}.csv").write_text(text, encoding="utf-8")
    append_motions(checkout)


def append_motions(checkout):
    with open(checkout / "config/campaigns/small.yaml", "a", encoding="utf-8") as file:
        file.write(MOTIONS)


def test_a_campaign_with_ground_motions_says_whether_its_blocks_fall_as_kept(checkout, monkeypatch):
    add_motions(checkout)
    path = os.pathsep.join(str(checkout / part) for part in ("src", "hook"))
    done = checkout.snakemake(PYTHONPATH=path, TRACE=str(checkout / "trace"))
    assert done.returncode == 0, done.stderr
    for script in ("response.py", "fragility.py"):
        (trace, *_) = (checkout / "trace").glob(f"{script}*")
        imported = {Path(path).relative_to(checkout.folder) for path in trace.read_text().split("\n")}
        assert imported <= {Path(path).relative_to(ROOT) for path in code(ROOT / "workflow/scripts" / script)}
    folder = checkout / "results/small"
    batches = sorted(folder.glob("response/*.csv"))
    assert [path.name for path in batches] == [f"motions_{i}.csv" for i in range(3)]
    responses = pd.concat(map(pd.read_csv, batches), ignore_index=True)
    assert responses["motion"].nunique() == 5
    assert len(responses) == 2 * 5 * 3 * 3  # records, motions, scales, draws
    assert (responses.loc[responses["overturned"] == 1, "max_theta_ratio"] >= 1).all()
    shares = responses.groupby("test")["overturned"].mean()
    assert 0 < shares["tall_mat"] < 1
    curves = pd.read_csv(folder / "tables/fragility.csv")
    fitted = curves[(curves["kind"] == "fitted") & (curves["test"] == "tall_mat")]
    assert fitted.groupby("measure")["probability"].apply(lambda p: p.is_monotonic_increasing).all()
    assert (curves.loc[curves["kind"] == "counted", "n_motions"] == 5).all()
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Overturning under ground motions" in page
    assert "Probability of overturning" in page
    assert (folder / "figures/overturning.pdf").exists()
    assert checkout.planned() == {} and differences(folder, "shaken") == []
    monkeypatch.chdir(checkout.folder)
    packed = dict(supplement._motions(load_campaign("config/campaigns/small.yaml")))
    assert [*packed] == [f"raw/ground/motion_{i}.csv" for i in range(5)]

    whole = batches[1].read_bytes()
    batches[1].unlink()
    planned = checkout.planned()
    assert planned["response"] == 1
    assert not {"fit", "record", "tables"} & {*planned}
    hook, mark = checkout / "accident", checkout / "mark"
    hook.mkdir()
    shutil.copy(Path(__file__).with_name("accident.py"), hook / "sitecustomize.py")
    path = os.pathsep.join(str(checkout / part) for part in ("src", "accident"))
    when = {"PYTHONPATH": path, "ACCIDENT": "kill job", "MARK": str(mark), "AT": batches[1].name}
    assert checkout.snakemake(**when).returncode != 0
    assert mark.exists() and not batches[1].exists()
    assert checkout.snakemake(batches[1].relative_to(checkout.folder)).returncode == 0
    assert batches[1].read_bytes() == whole

    checkout.edit("config/campaigns/small.csv", "squat,mat,low,,,,", "squat,mat,low,record,,spilt water,")
    assert checkout.snakemake().returncode == 0
    curves = pd.read_csv(folder / "tables/fragility.csv")
    assert curves.loc[curves["test"] == "squat_mat", "kind"].tolist() == ["no_law"]
    assert (curves.loc[curves["test"] == "tall_mat", "kind"] != "no_law").all()
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "whether its block overturns is not known" in page
    assert "Not known, as no law explains the runs or no run is usable: squat_mat." in page

    motion = checkout / "raw/ground/motion_3.csv"
    motion.write_text(motion.read_text().replace("time [s],acceleration [g]", "time [s],acceleration"))
    done = checkout.snakemake()
    assert done.returncode != 0
    (line,) = {each for each in done.stderr.splitlines() if "states no unit of the acceleration" in each}
    assert line.startswith("raw/ground/motion_3.csv: ")


def test_ground_motions_that_are_not_there_are_one_line(checkout):
    append_motions(checkout)
    done = checkout.snakemake("--dry-run")
    assert done.returncode != 0
    assert "small.yaml: ground_motions.folder: raw/ground: there is no such folder" in done.stderr
    assert "Traceback" not in done.stderr
