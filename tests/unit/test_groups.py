import subprocess
import sys

import xarray as xr
from fabricated import identity, record

from freerock.products.groups import NotFitted, not_fitted_in, one_of_each, usable_runs
from freerock.products.netcdf import open_fits, write_fits


def test_usable_runs_are_neither_excluded_nor_failed():
    tree = record()
    assert list(usable_runs(tree)) == [1, 2]
    tree["run_1"].attrs["verdict"] = "fail"
    assert list(usable_runs(tree)) == [2]


def test_one_product_of_each_scene_is_opened_the_first_that_is_usable():
    opened = []

    def open_product(path):
        opened.append(path)
        return xr.DataTree(name=path)

    def usable(tree):
        return tree.name not in "ae"

    found = one_of_each(["a", "b", "c", "d", "e"], ["x", "x", "x", "y", "z"], open_product, usable)
    assert opened == ["a", "b", "d", "e"]
    assert [tree.name for tree in found] == ["b", "d", "e"]


def test_what_could_not_be_fitted_comes_back(tmp_path):
    missed = (NotFitted(1, "winkler not fitted: too short; hold longer"), NotFitted(None, "so"))
    attrs = identity("a", "b", "mat", "simulated") | {"verdict": "warn", "reasons": []}
    write_fits(tmp_path / "a.nc", {}, attrs | {"not_fitted": list(missed)})
    assert not_fitted_in(open_fits(tmp_path / "a.nc").attrs) == missed
    write_fits(tmp_path / "b.nc", {}, attrs)
    assert not_fitted_in(open_fits(tmp_path / "b.nc").attrs) == ()


def test_threads_may_read_and_write_datasets_at_once(tmp_path):
    """The netCDF library ends a process in which two threads are in it: they wait for one another."""
    code = """
import sys
from concurrent.futures import ThreadPoolExecutor
import numpy as np, xarray as xr
from freerock.products.storage import groups_in, readable, write_groups

def work(i):
    time = np.arange(2000.0)
    groups = {"/": xr.Dataset({"theta": ("time", time)}, {"time": time}, {"origin": "measured"})}
    for j in range(30):
        path = f"{sys.argv[1]}/{i}_{j}.nc"
        write_groups(path, groups)
        with readable(path) as file:
            assert dict(groups_in(file, True))["/"].sizes == {"time": 2000}
    return i

with ThreadPoolExecutor(4) as pool:
    print(sorted(pool.map(work, range(4))))
"""
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "[0, 1, 2, 3]\n"), done.stderr
