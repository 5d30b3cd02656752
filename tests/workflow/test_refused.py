"""What is refused before anything runs: our own line is the last one told, and nothing is written."""

import pytest
from small_campaign import CAMPAIGN, add_campaign, check_out


@pytest.fixture
def lab(tmp_path):
    checkout = check_out(tmp_path / "checkout")
    add_campaign(checkout, "lab", CAMPAIGN, [("one", "", "tall")])
    (checkout / "raw/lab").mkdir(parents=True)
    return checkout


def broken_yaml(checkout):
    (checkout / "config/config.yaml").write_text("campaigns: [lab\n  two: {\n")


def no_config(checkout):
    (checkout / "config/config.yaml").unlink()


def studies(checkout):
    (checkout / "config/config.yaml").write_text("campaigns: [studies]\n")


def no_raw_folder(checkout):
    (checkout / "raw/lab").rename(checkout / "raw/elsewhere")


def left_to_fill_in(checkout):
    checkout.edit("config/campaigns/lab.yaml", "mass_kg: 5.84", "mass_kg: FILL_IN")


REFUSED = {
    broken_yaml: "config/config.yaml:1: expected ',' or ']', but got ':'; "
    "close the brace, bracket or quote that opens here, with commas between",
    no_config: "config/config.yaml: cannot be read (No such file or directory); "
    "put it there, or correct its name",
    studies: "config/config.yaml:1: campaigns: 'studies' is a folder of results; rename the campaign",
    no_raw_folder: "raw/lab: there is no such folder; put the record files there",
    left_to_fill_in: "config/campaigns/lab.yaml:4: blocks.tall.mass_kg: is still to be filled in; "
    "give the mass in kilograms",
}


@pytest.mark.parametrize("spoil", REFUSED, ids=lambda spoil: spoil.__name__)
def test_the_last_line_tells_it(lab, spoil):
    spoil(lab)
    done = lab.snakemake("--dry-run")
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == REFUSED[spoil]
    assert "Traceback" not in done.stderr
    assert not (lab / "results").exists()


def test_a_misspelt_option_is_told(lab):
    done = lab.snakemake("--dry-run", "--config", "campaign=lab")
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "--config: campaign: unknown key; did you mean 'campaigns'?"


@pytest.mark.parametrize("target", ["results/lob/complete.txt", "results/lab/figures/modls.pdf"])
def test_a_misspelt_campaign_or_figure_is_refused(lab, target):
    done = lab.snakemake("--dry-run", target)
    assert done.returncode == 1
    assert target in done.stdout + done.stderr
