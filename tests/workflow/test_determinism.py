"""Same inputs, same bytes."""

import shutil


def test_second_run_from_empty_gives_the_same_bytes(finished, checkout):
    shutil.rmtree(checkout / "results")
    assert checkout.snakemake().returncode == 0
    assert checkout.products() == finished.products()
