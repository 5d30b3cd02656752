"""What `freerock check` doubts in the configuration, each run tells too: once, a line each."""


def told(done):
    assert done.returncode == 0, done.stderr
    return [line for line in done.stderr.splitlines() if line.startswith("doubt: ")]


def test_each_run_tells_the_doubts_about_its_configuration_once(checkout):
    assert told(checkout.snakemake()) == []
    manifest = checkout / "raw/small/manifest.csv"
    manifest.write_text(manifest.read_text() + f"other.tdms,{'0' * 64},1\n")
    expected = "doubt: config/campaigns/small.csv: no line names other.tdms, which raw/small/manifest.csv lists; "
    expected += "add a line for it, or take it out of the manifest"
    assert told(checkout.snakemake()) == [expected]
    assert told(checkout.snakemake("--dry-run")) == []
