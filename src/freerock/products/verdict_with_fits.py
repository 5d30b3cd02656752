"""The verdict on a run from its products: from what was measured, and from what the fits make of it."""

import xarray as xr

from freerock.products.groups import not_fitted_in, reasons_in
from freerock.runs.verdict import Level, Reason, Verdict


def verdict_of_run(number: int, run: xr.DataTree, fits: xr.DataTree | None) -> Verdict:
    """Verdict of a run: as measured, then with the reasons of its fits.

    Where a model could not be fitted to a usable run, its reasons say why; where none could, it is failed.
    What fits say against a run is found by `selection.reasons_after_fits`.

    Parameters
    ----------
    number : int
    run : xarray.DataTree
        Its group in the dataset of the record.
    fits : xarray.DataTree or None
        Dataset of the record's fits.
    """
    verdict = Verdict(reasons_in(run.attrs))
    if fits is None:
        return verdict
    group = fits.children.get(f"run_{number}")
    missed = not_fitted_in(fits.attrs)
    if missed and verdict.level != "fail" and not run.attrs["excluded"]:
        lost: Level = "warn" if group is not None else "fail"
        of = {number: "", None: "not fitted: "}
        texts = (of[each.run] + each.text for each in missed if each.run in of)
        verdict = verdict.adding(Reason.of("not_fitted", text, lost) for text in texts)
    return (
        verdict.adding(reasons_in(group.attrs)) if group is not None and "reasons" in group.attrs else verdict
    )
