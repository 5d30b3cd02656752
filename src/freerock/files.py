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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from errno import EINVAL, ENAMETOOLONG, ENOENT
from pathlib import Path, PurePosixPath
from secrets import token_hex
from typing import Any

from freerock import bounds
from freerock.errors import FreerockError, exit_code

MANIFEST = "manifest.csv"
PARTIAL = ".*.partial*"  # names of files that are being written
CHECKSUM_COLUMNS = ["file", "sha256", "bytes"]
ROOM_REMEDY = "free some space or allow writing to the folder"
REMEDIES = {ENOENT: "write the file", ENAMETOOLONG: "shorten its name"}  # of a file that can't be read
SPECIAL = {
    stat.S_IFIFO: "a FIFO",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def special(mode: int) -> str:
    """What a path names by its mode, where that is neither file nor folder; else empty."""
    return SPECIAL.get(stat.S_IFMT(mode), "")


def check_special(path: str | Path, mode: int) -> None:
    """Refuse a FIFO, a socket or a device in the place of a file, which might be waited for without end.

    Raises
    ------
    FreerockError
        By its mode it is one.
    """
    if kind := special(mode):
        raise FreerockError(path, f"is {kind}, not a file", "remove it, or put the file in its place")


def regular(path: str, flags: int) -> int:
    """Open a file and nothing else, for the `opener` of `open`; OSError for a FIFO, a socket or a device."""
    with suppress(FileNotFoundError):
        if kind := special(os.stat(path).st_mode):
            raise OSError(EINVAL, f"{kind}, not a file", path)
    return os.open(path, flags | os.O_NONBLOCK, 0o666)


def read_bytes(path: str | Path, most_bytes: int | None = None) -> bytes:
    """What a file holds.

    Raises
    ------
    FreerockError
        It can't be read, or is longer than `most_bytes`.
    """
    try:
        with open(path, "rb", opener=regular) as file:
            content = file.read() if most_bytes is None else file.read(most_bytes + 1)
    except OSError as error:
        remedy = REMEDIES.get(error.errno or 0, "put a file there that you may read")
        raise FreerockError(path, f"cannot be read ({error.strerror})", remedy) from None
    if most_bytes is not None and len(content) > most_bytes:
        raise FreerockError(path, f"has more than {most_bytes} bytes", "split it into several campaigns")
    return content


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
        raise FreerockError(path, f"cannot be written ({error.strerror or error})", ROOM_REMEDY) from error
    finally:
        with suppress(OSError):
            partial.unlink()


def replace_together(contents: Mapping[Path, bytes]) -> None:
    """Replace several files, all or none, also where the process is killed or the disk full meanwhile.

    What they will hold is written beside them first. The renaming of the first file decides: before it
    nothing has happened, after it `recover` renames the others. The caller holds a lock.

    Parameters
    ----------
    contents : mapping of Path to bytes
        What each file will hold; one that exists keeps its rights.

    Raises
    ------
    FreerockError
        A file can't be written: all are as they were.
    """
    recover([*contents])
    first = path = next(iter(contents))
    try:
        for path, content in contents.items():
            with open(_next(path, path == first), "wb", opener=regular) as file:
                if path.exists():
                    os.chmod(file.fileno(), stat.S_IMODE(path.stat().st_mode))
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        _sync_folders(contents)
        os.replace(_next(first, True), first)
    except BaseException as error:
        _drop([*contents])
        if not isinstance(error, OSError):
            raise
        raise FreerockError(path, f"cannot be written ({error.strerror or error})", ROOM_REMEDY) from error
    with suppress(OSError, FreerockError):  # it has happened: `recover` does the rest
        _sync_folders(contents)
        recover([*contents])


def recover(paths: Sequence[Path]) -> None:
    """Finish what a killed `replace_together` had decided, or remove what it had begun.

    Parameters
    ----------
    paths : sequence of path
        All files that are replaced together, or alone, under the same lock.

    Raises
    ------
    FreerockError
        The folder can't be written.
    """
    if any(_next(path, True).exists() for path in paths):
        _drop(paths)
        return
    path = paths[0]
    try:
        for path in paths:
            if _next(path, False).exists():
                os.replace(_next(path, False), path)
    except OSError as error:
        raise FreerockError(path, f"cannot be written ({error.strerror or error})", ROOM_REMEDY) from error


def _next(path: Path, first: bool) -> Path:
    """Where what a file will hold is written, whose renaming decides or follows."""
    return path.with_name(f".{path.name}.{'first' if first else 'then'}")


def _drop(paths: Sequence[Path]) -> None:
    """Remove what was written, the first file's last: without it the others would count as decided."""
    with suppress(OSError):  # one that can't be removed keeps the first
        for first in (False, True):
            for path in paths:
                _next(path, first).unlink(missing_ok=True)


def _sync_folders(paths: Iterable[Path]) -> None:
    """Let the names of files reach the disk."""
    for folder in {path.parent for path in paths}:
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


def write_json(path: str | Path, data: Mapping[str, Any]) -> None:
    """Write sorted, indented JSON."""
    write_text(path, json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False) + "\n")


def read_json(path: str | Path, remedy: str) -> Any:
    """What a JSON file holds; no file is longer than bounds.JSON_BYTES.

    Raises
    ------
    FreerockError
        With the remedy: the file is missing, too long, or no JSON.
    """
    try:
        with open(path, "rb", opener=regular) as file:
            content = file.read(bounds.JSON_BYTES + 1)
        if len(content) > bounds.JSON_BYTES:
            raise FreerockError(path, f"has more than {bounds.JSON_BYTES} bytes", remedy)
        return json.loads(content.decode())
    except OSError as error:
        raise FreerockError(path, str(error.strerror), remedy) from error
    except (ValueError, RecursionError) as error:
        what = "brackets without end" if isinstance(error, RecursionError) else error
        raise FreerockError(path, f"is not JSON ({what})", remedy) from error


def write_text(path: str | Path, text: str) -> None:
    """Write a text, replacing the file in one step."""
    with atomic(path) as part:
        part.write_text(text, encoding="utf-8")


def sha256(path: str | Path) -> str:
    """SHA-256 of a file, hexadecimal; FreerockError where it can't be read."""
    try:
        with open(path, "rb", opener=regular) as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise FreerockError(
            path, f"can't be read: {error.strerror}", "check the file and its rights"
        ) from error


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
        with open(manifest, newline="", encoding="utf-8-sig", opener=regular) as stream:
            rows = csv.DictReader(stream)
            columns, listed = rows.fieldnames or (), list(rows)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FreerockError(manifest, f"can't be read ({error})", "save it as CSV in UTF-8") from error
    if not {"file", "sha256"} <= set(columns):
        raise FreerockError(
            manifest, "has no columns file and sha256", f"write {','.join(CHECKSUM_COLUMNS)} first"
        )
    for row in listed:
        if not row["sha256"]:
            raise FreerockError(manifest, f"lists no sha256 of {row['file']}", "write the manifest again")
    return {plain_path(row["file"]): row["sha256"] for row in listed}


def plain_path(path: str) -> str:
    """A path as it is written without detours: `a/b` for `./a//b`."""
    return PurePosixPath(path).as_posix()


def check_manifest(folder: str | Path, files: Iterable[str] | None = None) -> None:
    """Refuse raw files that are no longer what manifest.csv says; without a manifest nothing is refused.

    Parameters
    ----------
    folder : path
        Folder of the raw files and of manifest.csv.
    files : iterable of str, optional
        Files to check, relative to the folder; one that is not listed passes. Left out, all listed files.

    Raises
    ------
    FreerockError
        A file is missing or has another checksum; the manifest has other columns.
    """
    folder = Path(folder)
    listed = listed_checksums(folder)
    for file in listed if files is None else map(plain_path, files):
        if file not in listed:
            continue
        check_file(folder, file, listed[file])


def check_file(folder: str | Path, file: str, listed: str) -> None:
    """Refuse a raw file whose SHA-256 is not the one listed; raises as `check_manifest`."""
    path, manifest = Path(folder, file), Path(folder, MANIFEST)
    if not path.is_file():
        raise FreerockError(path, f"is missing but listed in {manifest}", "restore the file")
    found = sha256(path)
    if found != listed.casefold():
        raise FreerockError(
            path,
            f"has the sha256 {found}, {manifest} lists {listed}",
            f"restore the file; if the change is meant: python -m freerock.files {folder}",
        )


def raw_files(folder: Path) -> list[str]:
    """Files in a folder and its subfolders, relative to it, without its manifest and hidden ones."""
    found = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    shown = (file.as_posix() for file in found if not any(part.startswith(".") for part in file.parts))
    return [file for file in shown if file != MANIFEST]


def write_manifest(folder: str | Path, files: Iterable[str]) -> Path:
    """Write manifest.csv for files of a folder, named relative to it; returns its path."""
    folder = Path(folder)
    manifest = folder / MANIFEST
    rows = [[file, sha256(folder / file), (folder / file).stat().st_size] for file in sorted(files)]
    with atomic(manifest) as partial, open(partial, "w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([CHECKSUM_COLUMNS, *rows])
    return manifest


def renew_manifest(arguments: Sequence[str]) -> int:
    """Renew the manifest of the folder given on the command line; returns the exit code."""

    def renew() -> None:
        if len(arguments) != 1 or not Path(arguments[0]).is_dir():
            raise FreerockError("freerock.files", "no folder given", "name one, as raw/palermo_virtual")
        folder = Path(arguments[0])
        print(write_manifest(folder, raw_files(folder)))

    return exit_code(renew)


if __name__ == "__main__":
    sys.exit(renew_manifest(sys.argv[1:]))
