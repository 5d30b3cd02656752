"""Groups of variables into a netCDF file and out of it; several times faster than xarray's own way.

Same inputs, same bytes: no time stamp is written. A product is written whole by `files.atomic`;
`open_product` refuses a damaged one. The datasets have one vocabulary: each variable has its unit and long
name in `variables.csv`. The variables of a fit are in `netcdf`, the columns of tables in `freerock.columns`.
"""

import csv
import json
from collections.abc import Collection, Container, Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from freerock.errors import FreerockError
from freerock.files import atomic
from freerock.products.root_text import DAMAGED, errors_of
from freerock.rotation.flags import FLAGS
from freerock.runs.verdict import Reason

if TYPE_CHECKING:
    import netCDF4


# Field of Run and of Impacts -> variable of the dataset, whose unit is an attribute.
OF_RUN = ["hold_start_s", "release_s", "release_stderr_s", "fit_start_s", "end_s", "theta0", "theta0_stderr"]
OF_RUN += ["zero_stderr", "sigma_theta", "n_impacts"]
RUN_VARIABLES = {field: field.removesuffix("_s") for field in OF_RUN}

OF_IMPACTS = ["peak_before_rad", "peak_before_stderr_rad", "peak_after_rad", "peak_after_stderr_rad"]
OF_IMPACTS += ["restitution", "restitution_stderr"]
IMPACT_VARIABLES = {"time_s": "impact_time", "time_stderr_s": "impact_time_stderr"}
IMPACT_VARIABLES |= {field: field.removesuffix("_rad") for field in OF_IMPACTS}

WITH_TOTAL = ("peak_before", "peak_after", "restitution")  # of an impact, with a total uncertainty NAME_u

with open(Path(__file__).with_name("variables.csv"), encoding="utf-8", newline="") as file:
    # By name: unit ("" for texts, flags and what has the unit of a parameter; "1" is not written), long name,
    # and what the flags 0 and 1 mean.
    VARIABLES = {row["name"]: row for row in csv.DictReader(file)}
SAMPLE_FLAGS = {
    "standard_name": "quality_flag",
    "flag_masks": np.array(list(FLAGS.values()), np.uint8),
    "flag_meanings": " ".join(FLAGS),
}
BESIDE = {
    "theta": ("sigma_theta", "flags"),
    **{name: (f"{name}_u",) for name in ("theta0", *WITH_TOTAL)},
    "value": ("stderr", "u_law", "u_total", "unit"),
}
DRAWN = {"time", "theta", "theta_model", "residual"}  # along an axis of a plot that xarray labels
SINGLE_PRECISION = {"sigma_theta", "theta_model", "residual", "voltage", "voltage_2", "current", "current_2"}


def describe(name: str, present: Container[object] = ()) -> dict[str, Any]:
    """CF attributes of a variable among those present beside it."""
    row = VARIABLES[name.removesuffix("_stderr").removesuffix("_2")]
    error = "standard error of the " if name.endswith("_stderr") else ""
    attrs: dict[str, Any] = {"long_name": error + row["long_name"]}
    if row["unit"] not in ("", "1"):
        attrs["units"] = row["unit"]
    beside = [other for other in (f"{name}_stderr", *BESIDE.get(name, ())) if other in present]
    if beside:
        attrs["ancillary_variables"] = " ".join(beside)
    if row["flag_meanings"]:
        attrs |= {"flag_values": np.array([0, 1], np.int8), "flag_meanings": row["flag_meanings"]}
    return attrs | (SAMPLE_FLAGS if name == "flags" else {})


def root_attributes(product: str, done: str, attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Root attributes of a product."""
    of = [attrs[key] for key in ("campaign", "test") if key in attrs]
    source = "simulated " * (attrs["origin"] == "simulated") + "laser record of a free-rocking test"
    return {
        "Conventions": "CF-1.11, ACDD-1.3",
        "title": ": ".join(of),
        "keywords": "rocking, rigid block, free rocking test, restitution, Housner, Winkler, Hunt-Crossley",
        **attrs,
        "summary": attrs.get("summary") or f"A {source}.",
        "id": "/".join([*of, product]),
        "freerock_product": product,
        "source": source,
        "history": f"freerock {version('freerock')}: {done}",
    }


ONE_THREAD = RLock()  # two in the netCDF library at once end the process


def write_groups(path: str | Path, groups: Mapping[str, xr.Dataset], named: bool = True) -> None:
    """Write the groups of a file, what runs over time compressed.

    `named`: each variable has its long name. Else only what is drawn has it, so that the head of a file whose
    groups are alike stays short, and the root's attribute long_names has the others.
    """
    import netCDF4

    with ONE_THREAD, atomic(path) as partial:
        try:
            with netCDF4.Dataset(partial, "w") as file:
                if not named:
                    known = {str(name) for each in groups.values() for name in each.variables}
                    told = {name: describe(name)["long_name"] for name in sorted(known - DRAWN)}
                    file.setncatts(_plain({"long_names": told}))
                defined = [
                    each
                    for name, dataset in groups.items()
                    for each in _define(file if name == "/" else file.createGroup(name), dataset, named)
                ]
                for variable, values in defined:  # last: each return to definitions walks all groups
                    variable[...] = values
        except RuntimeError as error:  # what netCDF4 says of a full disk
            raise OSError(str(error)) from error


def _define(
    group: "netCDF4.Dataset", dataset: xr.Dataset, named: bool
) -> Iterator[tuple["netCDF4.Variable[Any]", Any]]:
    """Define the content of a group; yields each variable and its values."""
    group.setncatts(_plain(dataset.attrs))
    inherited = group.parent.dimensions if group.parent else {}
    for name, size in dataset.sizes.items():
        if name not in inherited or len(inherited[name]) != size:
            group.createDimension(str(name), size)
    beside = {name: set(dataset[name].dims) for name in dataset.coords if name not in dataset.dims}
    for key, variable in dataset.variables.items():
        name, dtype = str(key), variable.dtype.newbyteorder("=")  # netCDF4 warns of another name of the same
        if dtype.kind == "U":
            dtype = str
        elif name in SINGLE_PRECISION and variable.dims:
            dtype = np.float32
        missing = np.nan if variable.dtype.kind == "f" and np.isnan(variable.values).any() else None
        packed: dict[str, Any] = {"compression": "zlib", "complevel": 1} if "time" in variable.dims else {}
        dimensions = [str(each) for each in variable.dims]
        written = group.createVariable(name, dtype, dimensions, fill_value=missing, **packed)
        attrs = describe(name, dataset)
        if not named and name not in DRAWN:
            del attrs["long_name"]
        attrs |= variable.attrs
        coordinates = [str(other) for other in beside if beside[other] <= set(variable.dims)]
        if coordinates and name not in dataset.coords:
            attrs["coordinates"] = " ".join(coordinates)
        written.setncatts(attrs)
        yield written, variable.values.astype(object) if dtype is str else variable.values


def _plain(attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Attributes that netCDF can hold: nothing empty, 0 and 1 for booleans, JSON for groups."""
    plain: dict[str, Any] = {}
    for key, value in attrs.items():
        if isinstance(value, bool | np.bool_):
            plain[key] = int(value)
        elif isinstance(value, Mapping | list | tuple):
            plain[key] = json.dumps(value, sort_keys=True, ensure_ascii=False)
        elif value is not None:
            plain[key] = value
    return plain


def groups_in(
    group: "netCDF4.Dataset", samples: bool, only: Collection[str] = ()
) -> Iterator[tuple[str, xr.Dataset]]:
    """Path and content of a netCDF group and of those in it; several times faster than xarray's own way.

    `only` names variables, of which the others are not read.
    """
    variables, coordinates = {}, set[str]()
    for name, variable in group.variables.items():
        if (only and name not in only) or (not samples and "time" in variable.dimensions):
            continue
        attrs = dict(variable.__dict__)
        attrs.pop("_FillValue", None)
        coordinates |= set(attrs.pop("coordinates", "").split())
        values = np.asarray(variable[...], str if variable.dtype is str else None)
        variables[name] = xr.Variable(variable.dimensions, values, attrs)
        if name in variable.dimensions:
            coordinates.add(name)
    attrs = {key: group.getncattr(key) for key in group.ncattrs() if key != "coordinates"}
    data = {name: variables[name] for name in variables if name not in coordinates}
    present = {name: variables[name] for name in variables if name in coordinates}
    yield group.path, xr.Dataset(data, present, attrs)
    for inner in group.groups.values():
        yield from groups_in(inner, samples, only)


def open_product(
    path: str | Path, product: str, samples: bool = True, only: Collection[str] = ()
) -> xr.DataTree:
    """Read a product into memory; without samples, all but what runs over time; or `only` some variables.

    Raises
    ------
    FreerockError
        No such file, damaged, or another product.
    """
    import netCDF4

    with errors_of(path), ONE_THREAD, netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        tree = xr.DataTree.from_dict(dict(groups_in(file, samples, only)))
    if tree.attrs.get("freerock_product") != product:
        raise FreerockError(path, f"is not the {product} dataset of a record", DAMAGED)
    return tree


def reasons_in(attrs: Mapping[Any, Any]) -> tuple[Reason, ...]:
    """The reasons of a verdict among the attributes of a record, of its fits or of a run."""
    return tuple(Reason(*each) for each in json.loads(attrs["reasons"]))
