"""The supplement of a paper: a campaign with records, settings, code and products, for a repository."""

import hashlib
import json
import shutil
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path, PurePosixPath

from freerock.config.campaign import Campaign
from freerock.config.review_log import log_of
from freerock.config.step_settings import descriptions, record_attributes
from freerock.errors import FreerockError
from freerock.files import MANIFEST, atomic, listed_checksums, sha256
from freerock.jobs.crate import CRATE_FILE as CRATE
from freerock.jobs.crate import crate_json
from freerock.jobs.descriptions import described
from freerock.jobs.home import PACKAGE, PACKED
from freerock.jobs.ledger import LEDGER_FOLDER, read_entry
from freerock.jobs.metadata import Metadata, citation_cff, datacite_json, readme
from freerock.products.netcdf import open_fits, open_record
from freerock.response.motions import motion_files

CODE: tuple[str, ...] = ("Snakefile", "workflow", "profiles/default", "pyproject.toml", "setup.py")
CODE += ("requirements.lock", "Makefile", "LICENSE", "docs")
LEFT_OUT = {"__pycache__", "images", "tutorial"}  # folders: caches, and pictures of the documentation
EARLIEST = (1980, 1, 1, 0, 0, 0)  # a zip knows no earlier time; none is told, so that bytes stay
SUMS = "SHA256SUMS"
TEXTS = ("title", "summary", "institution", "creator_name", "license", "references", "comment")
GENERAL = {"title", "summary"}  # a dataset has these also where the configuration has none
STATE = ".git_archival.txt"  # as `git archive` writes it, read by `products.provenance`
Source = Path | bytes


def pack(campaign: Campaign, root: Path, path: Path, metadata: Metadata) -> int:
    """Write the supplement of a campaign: the same bytes for the same products, records, settings and code.

    Returns the number of files in it.

    Parameters
    ----------
    campaign : Campaign
        Its configuration is read again from config/campaigns of the current folder; its products, all whole,
        lie in results.
    root : Path
        The checkout of freerock whose workflow made them.
    path : Path
        Zip to write, in one step. What is in it lies in one folder, named as the zip.
    metadata : Metadata
        For the repository.

    Raises
    ------
    FreerockError
        A file is missing, changed since it was listed, or lies where it can't be packed from; a dataset holds
        other texts than the configuration, with which it would be made again; the zip can't be written.
        Nothing is left then.
    """
    _check_texts(campaign)
    made_by = json.loads(Path("results", campaign.name, "provenance.json").read_text(encoding="utf-8"))
    files: dict[str, Source] = dict(_code(root))
    files |= dict(_configuration(campaign)) | dict(_records(campaign)) | dict(_motions(campaign))
    files |= dict(_products(campaign.name))
    files[STATE] = f"describe-name: {made_by['git']}\n".encode()
    files["CITATION.cff"] = citation_cff(campaign, metadata).encode()
    files["datacite.json"] = datacite_json(campaign, metadata).encode()
    told = readme(campaign, metadata, made_by, _captions(campaign.name, files), files)
    files["README.md"] = told.encode()
    ledger = f"results/{campaign.name}/{LEDGER_FOLDER}/"
    sums = {name: _sha256(source) for name, source in sorted(files.items()) if not name.startswith(ledger)}
    crate = {name: (found, _size(files[name])) for name, found in sums.items()}
    files[CRATE] = crate_json(campaign, metadata, made_by, crate).encode()
    sums[CRATE] = _sha256(files[CRATE])
    files[SUMS] = "".join(f"{found}  {name}\n" for name, found in sums.items()).encode()
    folder = PurePosixPath(path.stem)
    with atomic(path) as partial, zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            _add(archive, str(folder / name), files[name])
    return len(files)


def _code(root: Path) -> Iterator[tuple[str, Source]]:
    """The workflow and the package, without caches, laid out as in a checkout; a wheel has no docs."""
    tops = {part: root / part for part in CODE} | {f"src/{PACKAGE.name}": PACKAGE}
    for part, top in tops.items():
        for file in [top] if top.is_file() else sorted(top.rglob("*")):
            inside = PurePosixPath(part, file.relative_to(top).as_posix())
            hidden = any(each.startswith(".") for each in inside.parts)
            packed = top == PACKAGE and file.is_relative_to(PACKED)
            if file.is_file() and not (hidden or packed or LEFT_OUT & {*inside.parts}):
                yield inside.as_posix(), file


def _configuration(campaign: Campaign) -> Iterator[tuple[str, Source]]:
    """The campaign's files, and a config.yaml that names it alone."""
    yield "config/config.yaml", f"campaigns: [{campaign.name}]\n".encode()
    table = Path(f"config/campaigns/{campaign.name}.csv")
    for file in (table.with_suffix(".yaml"), table, log_of(table)):
        if file.exists():
            yield file.as_posix(), file


def _records(campaign: Campaign) -> Iterator[tuple[str, Source]]:
    """The raw files that the campaign reads, refused where they are not as listed, and their manifest."""
    folder = _inside(campaign.raw, f"{campaign.name}: raw", "records")
    listed = listed_checksums(folder)
    names = [record.file for record in campaign.records]
    lasers = [campaign.lasers[name] for record in campaign.records for name in record.lasers]
    names += [laser.calibration for laser in lasers if laser.calibration]
    names = sorted({PurePosixPath(name).as_posix() for name in filter(None, [*names, campaign.truth])})
    for name in names:
        path = folder / name
        if not path.is_file():
            raise FreerockError(path, "is missing", "restore it, or exclude its record with a reason")
        if name in listed and sha256(path) != listed[name].casefold():
            raise FreerockError(
                path, f"is not as {folder / MANIFEST} lists it", "restore it, or renew the manifest"
            )
        yield path.as_posix(), path
    if listed:
        rows = [f"{name},{listed[name]},{(folder / name).stat().st_size}" for name in names if name in listed]
        yield (folder / MANIFEST).as_posix(), "\n".join(["file,sha256,bytes", *rows, ""]).encode()
    for path in sorted(folder.glob("README*")):
        yield path.as_posix(), path


def _motions(campaign: Campaign) -> Iterator[tuple[str, Source]]:
    """The accelerograms that the campaign names."""
    if campaign.ground_motions:
        where = f"{campaign.name}: ground_motions.folder"
        for path in motion_files(_inside(campaign.ground_motions.folder, where, "ground motions")):
            yield path.as_posix(), path


def _inside(folder: str, where: str, of: str) -> Path:
    """A folder of the configuration, refused where it is not below the current one."""
    parts = PurePosixPath(folder)
    if parts.is_absolute() or ".." in parts.parts:
        what = f"{folder}: the {of} lie outside of this folder"
        raise FreerockError(where, what, "move them to raw and analyse again")
    return Path(parts)


def _products(name: str) -> Iterator[tuple[str, Source]]:
    """The products that the ledger vouches for, and the ledger without how files looked on this machine."""
    for path in sorted(Path("results", name, LEDGER_FOLDER).glob("*.json")):
        entry = read_entry(path)
        if entry is None:
            raise FreerockError(path, "can't be read", "run snakemake")
        if not any(Path(product).exists() for product in entry.outputs):  # a figure no longer wanted
            continue
        text = json.dumps(asdict(entry) | {"looks": {}}, ensure_ascii=False, indent=1) + "\n"
        yield path.as_posix(), text.encode()
        for product, listed in entry.outputs.items():
            if sha256(product) != listed:
                raise FreerockError(product, "is not as it was written", "run snakemake")
            yield product, Path(product)


def _check_texts(campaign: Campaign) -> None:
    """Refuse datasets with other titles, names and notes than the configuration has by now."""
    texts = {campaign.name: descriptions(campaign)}
    for record in campaign.records:
        own = {record.test: {"attributes": record_attributes(campaign, record)}}
        now = described(own, texts)[record.test]["attributes"]
        for kind, opened in (("records", open_record), ("fits", open_fits)):
            path = f"results/{campaign.name}/{kind}/{record.test}.nc"
            then = opened(path, samples=False).attrs
            differ = [name for name in TEXTS if name in {**now, **then} and then.get(name) != now.get(name)]
            differ = [name for name in differ if name in now or name not in GENERAL]
            if differ:
                remedy = f"run snakemake --forceall --config campaigns={campaign.name}"
                what = f"holds another {' and '.join(differ)} than the configuration"
                raise FreerockError(path, what, remedy)


def _captions(campaign: str, files: Mapping[str, Source]) -> dict[str, str]:
    """Captions of the packed figures in the order of captions.tex, by the name of their files."""
    folder = Path("results", campaign, "figures")
    text = (folder / "captions.tex").read_text(encoding="utf-8")
    found = (Path(name) for name in files if Path(name).parent == folder and name.endswith(".txt"))
    ordered = sorted(found, key=lambda path: (text.find(f"fig:{path.stem}}}"), path.stem))
    return {path.stem: " ".join(path.read_text(encoding="utf-8").split()) for path in ordered}


def _size(source: Source) -> int:
    return len(source) if isinstance(source, bytes) else source.stat().st_size


def _sha256(source: Source) -> str:
    return hashlib.sha256(source).hexdigest() if isinstance(source, bytes) else sha256(source)


def _add(archive: zipfile.ZipFile, name: str, source: Source) -> None:
    """Add a file without its time, owner or rights."""
    info = zipfile.ZipInfo(name, EARLIEST)
    info.compress_type, info.create_system = zipfile.ZIP_DEFLATED, 3
    info.external_attr = 0o100644 << 16
    with archive.open(info, "w", force_zip64=_size(source) > 2**31) as packed:
        if isinstance(source, bytes):
            packed.write(source)
            return
        with open(source, "rb") as stream:
            shutil.copyfileobj(stream, packed, 1 << 20)
