"""What is refused before anything runs: our own line is the last one told, and nothing is written."""

import pytest
from small_campaign import CAMPAIGN, add_campaign, check_out


@pytest.fixture
def lab(tmp_path):
    checkout = check_out(tmp_path / "checkout")
    add_campaign(checkout, "lab", CAMPAIGN, [("one", "", "tall")])
    (checkout / "raw/lab").mkdir(parents=True)
    (checkout / "raw/lab/truth.json").write_text("{}")
    return checkout


def broken_yaml(checkout):
    (checkout / "config/config.yaml").write_text("campaigns: [lab\n  two: {\n")


def no_config(checkout):
    (checkout / "config/config.yaml").unlink()


def studies(checkout):
    (checkout / "config/config.yaml").write_text("campaigns: [studies]\n")


def no_truth(checkout):
    (checkout / "raw/lab/truth.json").unlink()


def wrong_truth(checkout):
    (checkout / "raw/lab/truth.json").write_text('{"one": {"runs": []}}')


def no_raw_folder(checkout):
    (checkout / "raw/lab").rename(checkout / "raw/elsewhere")


def left_to_fill_in(checkout):
    checkout.edit("config/campaigns/lab.yaml", "mass_kg: 5.84", "mass_kg: FILL_IN")


REFUSED = {
    broken_yaml: "config/config.yaml:2: expected ',' or ']', but got ':'; "
    "correct the YAML; indent with spaces, not tabs",
    no_config: "config/config.yaml: cannot be read (No such file or directory); write the file",
    studies: "config/config.yaml:1: campaigns: 'studies' names the results of the studies; "
    "rename the campaign",
    no_truth: "raw/lab/truth.json: No such file or directory; restore the file, or remove the key truth",
    wrong_truth: "raw/lab/truth.json: one: does not hold the model and its parameters run by run "
    "(KeyError: 'model'); restore the file, or remove the key truth",
    no_raw_folder: "config/campaigns/lab.yaml: raw: there is no folder raw/lab; put the records there",
    left_to_fill_in: "config/campaigns/lab.yaml:5: blocks.tall.mass_kg: is still to be filled in; "
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


@pytest.mark.parametrize(
    ("target", "told"),
    [
        (
            "results/lob/complete.txt",
            "results/lob: 'lob' is not among the campaigns to analyse; did you mean 'lab'?",
        ),
        (
            "results/marble/tables/runs.csv",
            "results/marble: 'marble' is not among the campaigns to analyse; use one of lab",
        ),
        (
            "results/lab/figures/modls.pdf",
            "results/lab/figures/modls.pdf: 'modls' is not a figure; did you mean 'models'?",
        ),
        (
            "results/lob/records/one.nc",
            "results/lob: 'lob' is not among the campaigns to analyse; did you mean 'lab'?",
        ),
        (
            "./results/lab/fits/oen.nc",
            "results/lab/fits/oen.nc: 'oen' is not a record of this campaign; did you mean 'one'?",
        ),
        (
            "results/lab/figures/qc_on.pdf",
            "results/lab/figures/qc_on.pdf: 'on' is not a record of this campaign; did you mean 'one'?",
        ),
    ],
)
def test_a_misspelt_target_is_told(lab, target, told):
    done = lab.snakemake("--dry-run", target)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == told
    assert "Traceback" not in done.stderr
