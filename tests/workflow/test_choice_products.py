"""What explains the runs of a small campaign, from the fits to the report."""

from freerock.models.laws import CANDIDATES
from freerock.products.choices import choices_of
from freerock.products.netcdf import open_fits
from freerock.tables.csvfile import read_csv


def test_the_choice_of_each_run_is_the_same_in_every_product(finished):
    results = finished / "results/small"
    choice, table, epsilon = (
        read_csv(results / f"tables/{name}.csv") for name in ("choice", "candidates", "epsilon")
    )
    named = choice[choice["status"] == "selected"]
    keys = ["test", "run", "model"]
    assert named[keys].values.tolist() == epsilon[epsilon["selected"]][keys].values.tolist()
    stored = [
        (test, str(run), found.attrs["selected"])
        for test in ("tall_mat", "squat_mat")
        for run, found in choices_of(open_fits(results / f"fits/{test}.nc", samples=False))
    ]
    assert sorted(stored) == sorted(map(tuple, named[keys].values.tolist()))
    assert named["explains"].all()
    assert named["model"].str.startswith("hunt_crossley").all()
    assert table["n_selected"].sum() == (choice["status"] == "selected").sum() == 2
    assert set(table["model"]) <= set(CANDIDATES)
    assert (results / "tables/candidates.md").read_text(encoding="utf-8").count("Hunt–Crossley") >= 2
    assert "booktabs" not in (results / "tables/candidates.tex").read_text(encoding="utf-8")


def test_the_report_says_what_explains_each_scene(finished):
    page = (finished / "results/small/report.html").read_text(encoding="utf-8")
    assert page.count("Hunt–Crossley explains the run: its residual is the noise of the sensor at rest") == 1
    assert page.count('<table class="evidence">') == 1 and page.count('<tbody id="evidence-') == 2
    assert "No candidate explains" not in page
