"""A campaign of one law: nothing in its tables, figures and report needs another."""

import pytest
from small_campaign import CAMPAIGN, add_campaign, check_out, simulated

from freerock.tables.csvfile import read_csv
from freerock.virtual_lab.write_tdms import write_tdms

pytestmark = pytest.mark.slow


def test_a_law_alone_makes_a_report(tmp_path):
    checkout = check_out(tmp_path)
    (checkout / "raw/lab").mkdir(parents=True)
    write_tdms(checkout / "raw/lab/squat_mat.tdms", simulated("squat", 1, angle_deg=10))
    for law in ("housner", "general"):  # rigid and on a bed
        as_paper = str(law == "housner").lower()  # frees no release
        fits = f"fits: {{models: [{law}], paper_mode: {as_paper}}}\n"
        add_campaign(checkout, "lab", CAMPAIGN + fits, [("squat_mat", "", "squat")])
        done = checkout.snakemake()
        assert done.returncode == 0, f"{law}: {done.stderr}"
        parameters = read_csv(checkout / "results/lab/tables/parameters.csv")
        assert all(model.startswith(law) for model in parameters["model"])  # and its rivals
        assert all(isinstance(unit, str) for unit in parameters["unit"])
        assert (checkout / "results/lab/report.html").exists()
