"""The verdict on a run from its products: the worst of what was measured and of what the fits say."""

import json

import xarray as xr

from freerock.products.contents import NotFitted, verdict_of_run

ATTRS = {"campaign": "c", "test": "a", "block": "b", "foundation": "f", "origin": "simulated"}
HIT = ["warn", "disturbed", "something acted on the block"]
UNEVEN = ["warn", "uneven_restitution", "restitution does not change smoothly"]


def run(*reasons, excluded=0):
    return xr.DataTree(xr.Dataset(attrs={"reasons": json.dumps(reasons), "excluded": excluded}))


def fits(reasons=None, not_fitted=()):
    """Fits of run 1 with what they say against it; without that group where reasons are None."""
    groups = {"/": xr.Dataset(attrs={"not_fitted": json.dumps(not_fitted)} if not_fitted else {})}
    if reasons is not None:
        groups["run_1"] = xr.Dataset(attrs={"reasons": json.dumps(reasons)} if reasons else {})
    return xr.DataTree.from_dict(groups)


def names(*of):
    found = verdict_of_run(1, *of)
    return found.level, list(found.names)


def test_ok_means_that_nothing_was_found():
    assert names(run(), fits([])) == ("ok", [])
    assert names(run(), None) == names(run(), fits()) == ("ok", [])


def test_what_the_fits_say_counts():
    assert names(run(), fits([HIT])) == ("warn", ["disturbed"])
    assert names(run(UNEVEN), fits([HIT])) == ("warn", ["uneven_restitution", "disturbed"])
    assert names(run(["fail", "touched", "swing 2"]), fits()) == ("fail", ["touched"])


def test_a_model_that_was_not_fitted_warns_and_none_at_all_fails():
    missed = [NotFitted(1, "winkler not fitted: too short")]
    assert names(run(), fits([], missed)) == ("warn", ["not_fitted"])
    assert names(run(), fits(None, missed)) == ("fail", ["not_fitted"])
    assert names(run(excluded=1), fits(None, missed)) == ("ok", [])
