"""Files written whole or not at all, and checksums of raw files."""

import hashlib
from pathlib import Path
from unittest.mock import Mock

import pytest

from freerock.errors import FreerockError
from freerock.files import (
    atomic,
    check_file,
    listed_checksums,
    read_bytes,
    renew_manifest,
    sha256,
    write_manifest,
)


@pytest.fixture
def folder(tmp_path):
    for name in ("a.tdms", "day1/b.tdms"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(name.encode())
    write_manifest(tmp_path, ["day1/b.tdms", "a.tdms"])
    return tmp_path


def test_manifest_lists_checksum_and_size(folder):
    checksums = [hashlib.sha256(name).hexdigest() for name in (b"a.tdms", b"day1/b.tdms")]
    assert (folder / "manifest.csv").read_text().splitlines() == [
        "file,sha256,bytes",
        f"a.tdms,{checksums[0]},6",
        f"day1/b.tdms,{checksums[1]},11",
    ]


def check(folder):
    for file, listed in listed_checksums(folder).items():
        check_file(folder, file, listed)


def test_unchanged_and_unlisted_files_pass(folder):
    (folder / "new.tdms").write_bytes(b"new")
    check(folder)


def test_changed_file_is_refused_with_both_checksums(folder):
    listed = sha256(folder / "a.tdms")
    (folder / "a.tdms").write_bytes(b"changed")
    with pytest.raises(FreerockError) as caught:
        check(folder)
    assert str(caught.value) == (
        f"{folder}/a.tdms: has the sha256 {sha256(folder / 'a.tdms')}, {folder}/manifest.csv lists {listed}; "
        f"restore the file; if the change is meant: python -m freerock.files {folder}"
    )


def test_missing_file_is_refused(folder):
    (folder / "a.tdms").unlink()
    with pytest.raises(FreerockError, match=r"a\.tdms: is missing but listed"):
        check(folder)


def test_without_a_manifest_nothing_is_listed(folder):
    (folder / "manifest.csv").unlink()
    assert listed_checksums(folder) == {}


def test_unreadable_manifest_is_refused(folder):
    (folder / "manifest.csv").write_bytes("file,sha256\nprüfung.tdms,0\n".encode("latin-1"))
    with pytest.raises(FreerockError, match=r"manifest\.csv: can't be read \(.*\); save it as CSV in UTF-8"):
        listed_checksums(folder)
    (folder / "manifest.csv").write_text("file,sha256\na.tdms\n")
    with pytest.raises(FreerockError, match=r"lists no sha256 of a\.tdms; write the manifest again"):
        listed_checksums(folder)


@pytest.mark.parametrize("listed", [True, False])
def test_renewing_lists_the_files_that_are_there_now(folder, listed, capsys):
    for name in ("day2/c.tdms", "day2/.hidden", ".cache/d.tdms"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(name.encode())
    (folder / "a.tdms").unlink()
    (folder / "day1/b.tdms").write_bytes(b"changed")
    if not listed:
        (folder / "manifest.csv").unlink()
    renew_manifest(str(folder))
    assert capsys.readouterr().out == f"{folder}/manifest.csv\n"
    names = ["day1/b.tdms", "day2/c.tdms"]
    assert listed_checksums(folder) == {name: sha256(folder / name) for name in names}
    check(folder)


def test_atomic_leaves_all_or_nothing(tmp_path):
    path = tmp_path / "tables" / "a.csv"
    with atomic(path) as partial:
        partial.write_text("new")
        assert not path.exists()
        assert partial.parent == path.parent
    assert path.read_text() == "new"
    with pytest.raises(KeyboardInterrupt), atomic(path) as partial:
        partial.write_text("half")
        raise KeyboardInterrupt
    assert [each.read_text() for each in path.parent.iterdir()] == ["new"]


@pytest.mark.parametrize(
    "error, remedy",
    [
        (FileNotFoundError(2, "No such file"), "put it there, or correct its name"),
        (PermissionError(13, "Permission denied"), "allow reading it"),
    ],
)
def test_what_cannot_be_read_is_told_by_why(monkeypatch, error, remedy):
    monkeypatch.setattr(Path, "read_bytes", Mock(side_effect=error))
    with pytest.raises(FreerockError, match=rf"lab\.yaml: cannot be read \({error.strerror}\); {remedy}"):
        read_bytes("lab.yaml")
