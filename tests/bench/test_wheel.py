"""The wheel holds what a laboratory runs with its workflow; the checkout, as editable, the bench as well."""

import zipfile
from importlib.util import find_spec
from pathlib import Path

from installed import ROOT, install
from small_campaign import once

WORKFLOW = ("Snakefile", "workflow", "profiles", "requirements.lock")


def files_of(folder, *parts):
    tops = [folder / part for part in parts]
    found = [path for top in tops for path in ([top] if top.is_file() else top.rglob("*"))]
    return {path.relative_to(folder).as_posix(): path for path in found if path.is_file()}


def test_a_wheel_holds_the_product_and_its_workflow(tmp_path_factory):
    (path,) = (once(tmp_path_factory, "installed", install) / "wheel").glob("*.whl")
    wheel = zipfile.ZipFile(path)
    expected = {f"freerock/snakemake/{name}": path for name, path in files_of(ROOT, *WORKFLOW).items()}
    expected |= files_of(ROOT / "src", "freerock")
    expected = {name: path for name, path in expected.items() if "__pycache__" not in name}
    held = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert held == expected.keys()
    assert [name for name, path in expected.items() if wheel.read(name) != path.read_bytes()] == []


def test_the_checkout_has_the_bench():
    assert Path(find_spec("freerock_bench").origin) == ROOT / "src/freerock_bench/__init__.py"
