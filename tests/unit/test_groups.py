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
