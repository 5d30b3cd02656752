"""Same inputs, same bytes."""

import shutil


def test_second_run_from_empty_gives_the_same_bytes(finished, checkout):
    """Each job in a Python of its own, as `snakemake` starts them."""
    shutil.rmtree(checkout / "results")
    assert checkout.snakemake(warm=False).returncode == 0
    assert checkout.products() == finished.products()
