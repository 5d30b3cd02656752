import xarray as xr
from fabricated import record

from freerock.products.contents import one_of_each, usable_runs


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
