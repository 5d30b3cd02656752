"""Files: written in one step, known by their checksums; manifest.csv lists those of the raw record files.

`python -m freerock.files raw/NAME` writes the manifest of a folder anew, after a change that is meant; hidden
files are left out.
"""

import csv
import hashlib
import json
import os
import stat
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from secrets import token_hex
from typing import Any

from freerock.errors import FreerockError, exit_code

MANIFEST = "manifest.csv"
CHECKSUM_COLUMNS = ["file", "sha256", "bytes"]


def read_bytes(path: str | Path) -> bytes:
    """What a file holds; FreerockError where it can't be read."""
    try:
        return Path(path).read_bytes()
    except OSError as error:
        there = isinstance(error, PermissionError)
        remedy = "allow reading it" if there else "put it there, or correct its name"
        raise FreerockError(path, f"cannot be read ({error.strerror})", remedy) from None


@contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path` and rename it to `path` at the end; on an error leave nothing.

    Raises
    ------
    FreerockError
        The file or its folder can't be written.
    """
    path = Path(path)
    partial = path.with_name(f".{token_hex(8)}.partial{path.suffix}")  # its own: others may write it too
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield partial
        with open(partial, "rb") as written:
            os.fsync(written.fileno())  # a power cut after the renaming leaves no empty file
        os.replace(partial, path)
    except OSError as error:
        what, remedy = error.strerror or error, "free some space or allow writing to the folder"
        raise FreerockError(path, f"cannot be written ({what})", remedy) from error
    finally:
        with suppress(OSError):
            partial.unlink()


def write_bytes(path: Path, content: bytes) -> None:
    """Replace what a file holds in one step; one that exists keeps its rights."""
    with atomic(path) as part:
        part.write_bytes(content)
        if path.exists():
            part.chmod(stat.S_IMODE(path.stat().st_mode))


def write_text(path: str | Path, text: str) -> None:
    """Write a text, replacing the file in one step."""
    write_bytes(Path(path), text.encode())


def write_json(path: str | Path, data: Mapping[str, Any]) -> None:
    """Write sorted, indented JSON."""
    write_text(path, json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False) + "\n")


def read_json(path: str | Path, remedy: str) -> Any:
    """What a JSON file holds; FreerockError with the remedy where it is missing or no JSON."""
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise FreerockError(path, str(error.strerror), remedy) from error
    except ValueError as error:
        raise FreerockError(path, f"is not JSON ({error})", remedy) from error


def sha256(path: str | Path) -> str:
    """SHA-256 of a file, hexadecimal; FreerockError where it can't be read."""
    try:
        with open(path, "rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        remedy = "check the file and its rights"
        raise FreerockError(path, f"can't be read: {error.strerror}", remedy) from error


def listed_checksums(folder: str | Path) -> dict[str, str]:
    """SHA-256 by file as manifest.csv of a folder lists them; empty without a manifest.

    Raises
    ------
    FreerockError
        The manifest can't be read, has other columns, or lacks a checksum.
    """
    manifest = Path(folder) / MANIFEST
    if not manifest.exists():
        return {}
    try:
        with open(manifest, newline="", encoding="utf-8-sig") as stream:
            rows = csv.DictReader(stream)
            columns, listed = rows.fieldnames or (), list(rows)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FreerockError(manifest, f"can't be read ({error})", "save it as CSV in UTF-8") from error
    if not {"file", "sha256"} <= set(columns):
        raise FreerockError(manifest, "has no columns file and sha256", "write the manifest again")
    for row in listed:
        if not row["sha256"]:
            raise FreerockError(manifest, f"lists no sha256 of {row['file']}", "write the manifest again")
    return {PurePosixPath(row["file"]).as_posix(): row["sha256"] for row in listed}


def check_file(folder: str | Path, file: str, listed: str) -> None:
    """Refuse a raw file that is no longer what manifest.csv lists.

    Parameters
    ----------
    folder : path
        Folder of the raw files and of manifest.csv.
    file : str
        Relative to the folder.
    listed : str
        Its SHA-256 in manifest.csv.

    Raises
    ------
    FreerockError
        The file is missing or has another checksum.
    """
    path, manifest = Path(folder, file), Path(folder, MANIFEST)
    if not path.is_file():
        raise FreerockError(path, f"is missing but listed in {manifest}", "restore the file")
    found = sha256(path)
    if found != listed.casefold():
        remedy = f"restore the file; if the change is meant: python -m freerock.files {folder}"
        raise FreerockError(path, f"has the sha256 {found}, {manifest} lists {listed}", remedy)


def write_manifest(folder: str | Path, files: Iterable[str]) -> Path:
    """Write manifest.csv for files of a folder, named relative to it; returns its path."""
    folder = Path(folder)
    manifest = folder / MANIFEST
    rows = [[file, sha256(folder / file), (folder / file).stat().st_size] for file in sorted(files)]
    with atomic(manifest) as partial, open(partial, "w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([CHECKSUM_COLUMNS, *rows])
    return manifest


def renew_manifest(folder: str = "") -> None:
    """List the files that are in a folder and its subfolders now, without hidden ones."""
    if not folder or not Path(folder).is_dir():
        raise FreerockError("freerock.files", "no folder given", "name one, as raw/palermo_virtual")
    found = (path.relative_to(folder) for path in Path(folder).rglob("*") if path.is_file())
    shown = (file.as_posix() for file in found if not any(part.startswith(".") for part in file.parts))
    print(write_manifest(folder, (file for file in shown if file != MANIFEST)))


if __name__ == "__main__":
    sys.exit(exit_code(lambda: renew_manifest(*sys.argv[1:2])))
