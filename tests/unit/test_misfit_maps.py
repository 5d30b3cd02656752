import numpy as np
import pytest
import xarray as xr

from freerock.errors import FreerockError
from freerock.populations.estimate import Estimate
from freerock.products.misfit_maps import mapped, open_misfit_maps, record_map, write_misfit_maps


def made_up(test="a", model="hunt_crossley", names=("k", "lambda")):
    grid, finer = np.array([1.0, 2.0, 3.0]), np.linspace(1.0, 3.0, 5)
    first, second = names
    arrays = {
        "epsilon_theta": ((second, first), np.eye(3)),
        "epsilon_finer": ((f"{second}_finer", f"{first}_finer"), np.full((5, 5), 1 / 3)),
    }
    sides = {first: grid, second: 2 * grid, f"{first}_finer": finer, f"{second}_finer": 2 * finer}
    covariance = np.array([[4.0, 1.0], [1.0, 1.0]])
    estimates = [
        Estimate("lab", test, run, "tall", "mat", model, {first: 2.0, second: 4.0}, covariance)
        for run in (1, 2)
    ]
    return record_map(xr.Dataset(arrays, sides), estimates)


def test_maps_come_back(tmp_path):
    write_misfit_maps(tmp_path / "maps.nc", [made_up(), made_up("b")], "lab", "simulated")
    maps = open_misfit_maps(tmp_path / "maps.nc")
    assert [each.attrs for each in maps] == [
        {"test": "a", "block": "tall", "foundation": "mat", "model": "hunt_crossley"},
        {"test": "b", "block": "tall", "foundation": "mat", "model": "hunt_crossley"},
    ]
    written = made_up()
    assert written["identified_run"].values.tolist() == [1, 2]
    assert written["correlation"].values[0] == 0.5
    xr.testing.assert_equal(maps[0], written)


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
    winkler = made_up(model="winkler", names=("k", "c"))
    write_misfit_maps(tmp_path / "maps.nc", [winkler], "lab", "simulated")
    (found,) = open_misfit_maps(tmp_path / "maps.nc")
    assert found.attrs["model"] == "winkler"
    xr.testing.assert_equal(found, winkler)


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
