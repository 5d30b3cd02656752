from dataclasses import replace

import numpy as np
import pytest

from freerock.errors import FreerockError
from freerock.populations.estimate import Estimate, MisfitMap
from freerock.products.misfit_maps import mapped, open_misfit_maps, record_map, write_misfit_maps


def made_up(test="a"):
    grid, finer = np.array([1.0, 2.0, 3.0]), np.linspace(1.0, 3.0, 5)
    found = MisfitMap(("k", "lambda"), grid, 2 * grid, np.eye(3), finer, 2 * finer, np.full((5, 5), 1 / 3))
    covariance = np.array([[4.0, 1.0], [1.0, 1.0]])
    estimates = [
        Estimate("lab", test, run, "tall", "mat", "hunt_crossley", {"k": 2.0, "lambda": 4.0}, covariance)
        for run in (1, 2)
    ]
    return record_map(found, estimates)


def test_maps_come_back(tmp_path):
    write_misfit_maps(tmp_path / "maps.nc", [made_up(), made_up("b")], "lab", "simulated")
    maps = open_misfit_maps(tmp_path / "maps.nc")
    assert [(each.test, each.block, each.foundation) for each in maps] == [
        ("a", "tall", "mat"),
        ("b", "tall", "mat"),
    ]
    written = made_up()
    assert maps[0].identified == written.identified
    assert [one.run for one in written.identified] == [1, 2]
    assert written.identified[0].correlation == 0.5
    for name in ("first", "second", "epsilon_theta", "first_finer", "second_finer", "epsilon_finer"):
        np.testing.assert_array_equal(getattr(maps[0].map, name), getattr(written.map, name))


def test_a_campaign_without_fits_has_no_map(tmp_path):
    write_misfit_maps(tmp_path / "maps.nc", [], "lab", "measured")
    assert open_misfit_maps(tmp_path / "maps.nc") == []


def test_same_maps_same_bytes(tmp_path):
    for name in ("one.nc", "other.nc"):
        write_misfit_maps(tmp_path / name, [made_up()], "lab", "simulated")
    assert (tmp_path / "one.nc").read_bytes() == (tmp_path / "other.nc").read_bytes()


def test_another_file_is_refused(tmp_path):
    with pytest.raises(FreerockError, match=r"maps\.nc: there is no such file"):
        open_misfit_maps(tmp_path / "maps.nc")


def test_a_map_of_winklers_law_comes_back_with_its_parameters(tmp_path):
    first = made_up()
    winkler = replace(first, model="winkler", map=replace(first.map, names=("k", "c")))
    write_misfit_maps(tmp_path / "maps.nc", [winkler], "lab", "simulated")
    (found,) = open_misfit_maps(tmp_path / "maps.nc")
    assert (found.model, found.map.names, found.identified) == ("winkler", ("k", "c"), first.identified)


@pytest.mark.parametrize(
    "named, usable, model",
    [
        ("winkler_pivoting", ["hunt_crossley", "winkler_pivoting"], "winkler_pivoting"),
        ("housner", ["housner", "winkler", "hunt_crossley"], "hunt_crossley"),
        ("general", ["general", "winkler"], "winkler"),
        ("housner", ["housner"], ""),
    ],
)
def test_the_map_is_of_the_named_law_where_it_has_two_parameters(named, usable, model):
    assert mapped(named, usable) == model
