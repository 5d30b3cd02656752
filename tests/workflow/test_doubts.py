"""What `freerock check` doubts in the configuration, each run tells too: once, a line each."""

from small_campaign import CAMPAIGN, add_campaign, check_out


def test_each_run_tells_the_doubts_about_its_configuration_once(tmp_path):
    checkout = check_out(tmp_path / "checkout")
    measured = CAMPAIGN.replace("origin: simulated\ntruth: truth.json\n", "origin: measured\n")
    add_campaign(checkout, "lab", measured, [("one", "", "tall"), ("two", "", "squat")])
    (checkout / "raw/lab").mkdir(parents=True)
    targets = [f"results/lab/records/{test}.nc" for test in ("one", "two")]

    def doubts(*options):
        done = checkout.snakemake(*options, *targets)
        assert done.returncode == 0, done.stderr
        return [line for line in done.stderr.splitlines() if line.startswith("doubt: ")]

    assert doubts("--dry-run") == []
    doubt, *missing = doubts()
    assert doubt.startswith("doubt: config/campaigns/lab.yaml:")
    assert "foundations.mat: has no levelled_deg" in doubt and "state levelled_deg" in doubt
    assert missing == [
        f"doubt: config/campaigns/lab.csv:{line}: {test}: there is no file raw/lab/{test}.tdms; "
        "put it there, or the record fails"
        for line, test in ((2, "one"), (3, "two"))
    ]
