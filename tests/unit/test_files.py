"""Files written whole or not at all, and checksums of raw files."""

import hashlib
import os
import socket
import subprocess
import sys

import pytest

from freerock.errors import FreerockError
from freerock.files import (
    PARTIAL,
    atomic,
    check_manifest,
    listed_checksums,
    read_bytes,
    read_json,
    recover,
    renew_manifest,
    replace_together,
    sha256,
    write_json,
    write_manifest,
)
from freerock.jobs.contents import look
from freerock.records.read import read_record


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


def test_unchanged_and_unlisted_files_pass(folder):
    (folder / "new.tdms").write_bytes(b"new")
    check_manifest(folder)
    check_manifest(folder, ["a.tdms", "new.tdms"])


def test_changed_file_is_refused_with_both_checksums(folder):
    listed = sha256(folder / "a.tdms")
    (folder / "a.tdms").write_bytes(b"changed")
    with pytest.raises(FreerockError) as caught:
        check_manifest(folder)
    assert str(caught.value) == (
        f"{folder}/a.tdms: has the sha256 {sha256(folder / 'a.tdms')}, {folder}/manifest.csv lists {listed}; "
        f"restore the file; if the change is meant: python -m freerock.files {folder}"
    )
    check_manifest(folder, ["day1/b.tdms"])


def test_missing_file_is_refused(folder):
    (folder / "a.tdms").unlink()
    with pytest.raises(FreerockError, match=r"a\.tdms: is missing but listed"):
        check_manifest(folder)


def test_without_a_manifest_nothing_is_refused(folder):
    (folder / "manifest.csv").unlink()
    check_manifest(folder, ["a.tdms", "nowhere.tdms"])


def test_foreign_manifest_is_refused(folder):
    (folder / "manifest.csv").write_text("name,md5\n")
    with pytest.raises(FreerockError, match="has no columns file and sha256; write file,sha256,bytes first"):
        check_manifest(folder)


def test_unreadable_manifest_is_refused(folder):
    (folder / "manifest.csv").write_bytes("file,sha256\nprüfung.tdms,0\n".encode("latin-1"))
    with pytest.raises(FreerockError, match=r"manifest\.csv: can't be read \(.*\); save it as CSV in UTF-8"):
        check_manifest(folder)
    (folder / "manifest.csv").write_text("file,sha256\na.tdms\n")
    with pytest.raises(FreerockError, match=r"lists no sha256 of a\.tdms; write the manifest again"):
        check_manifest(folder)


def test_checksums_in_capitals_pass(folder):
    manifest = folder / "manifest.csv"
    text = manifest.read_text()
    manifest.write_text(text.replace(sha256(folder / "a.tdms"), sha256(folder / "a.tdms").upper()))
    check_manifest(folder)


@pytest.mark.parametrize("listed", [True, False])
def test_renewing_lists_the_files_that_are_there_now(folder, listed, capsys):
    for name in ("day2/c.tdms", "day2/.hidden", ".cache/d.tdms"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(name.encode())
    (folder / "a.tdms").unlink()
    (folder / "day1/b.tdms").write_bytes(b"changed")
    if not listed:
        (folder / "manifest.csv").unlink()
    assert renew_manifest([str(folder)]) == 0
    assert capsys.readouterr().out == f"{folder}/manifest.csv\n"
    names = ["day1/b.tdms", "day2/c.tdms"]
    assert listed_checksums(folder) == {name: sha256(folder / name) for name in names}
    check_manifest(folder)


def test_renewing_takes_one_folder(folder, capsys):
    for arguments in ([], [str(folder / "a.tdms")], [str(folder), str(folder)]):
        assert renew_manifest(arguments) != 0
        assert "no folder given: name one" in capsys.readouterr().err.replace("; ", ": ")


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


def test_two_that_write_one_file_at_once_keep_out_of_each_others_way(tmp_path):
    path = tmp_path / "a.txt"
    with atomic(path) as one:
        one.write_text("one")
        with atomic(path) as other:
            other.write_text("other")
        assert path.read_text() == "other"
    assert path.read_text() == "one"
    assert [each.name for each in tmp_path.iterdir()] == ["a.txt"]


def test_what_a_killed_process_leaves_is_hidden_and_known_by_its_name(tmp_path):
    code = (
        "import os, sys; from freerock.files import atomic\n"
        "with atomic(sys.argv[1]) as partial: partial.write_text('half'); os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", code, tmp_path / "a.txt"]).returncode == 9
    with atomic(tmp_path / "a.txt") as partial:
        partial.write_text("whole")
    (left,) = tmp_path.glob(PARTIAL)
    assert (tmp_path / "a.txt").read_text() == "whole"
    assert left.suffix == ".txt"


@pytest.mark.parametrize("name", ["./a.tdms", ".//a.tdms", "day1/./b.tdms"])
def test_a_detour_to_a_file_does_not_pass_the_manifest(folder, name):
    (folder / name).write_bytes(b"changed")
    with pytest.raises(FreerockError, match="has the sha256"):
        check_manifest(folder, [name])


def test_a_detour_in_the_manifest_lists_the_file(folder):
    manifest = folder / "manifest.csv"
    manifest.write_text(manifest.read_text().replace("a.tdms", "./a.tdms"))
    assert {*listed_checksums(folder)} == {"a.tdms", "day1/b.tdms"}


def test_unwritable_folder_is_told(tmp_path):
    (tmp_path / "results").write_text("a file, not a folder")
    with pytest.raises(FreerockError, match=r"results/a\.json: cannot be written \(.*\); free some space"):
        write_json(tmp_path / "results" / "a.json", {})


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("none", "cannot be read (No such file or directory); write the file"),
        ("n" * 300, "cannot be read (File name too long); shorten its name"),
        (".", "cannot be read (Is a directory); put a file there that you may read"),
    ],
)
def test_the_remedy_is_that_of_the_fault(name, told, tmp_path):
    with pytest.raises(FreerockError) as refused:
        read_bytes(tmp_path / name)
    assert str(refused.value) == f"{tmp_path / name}: {told}"


@pytest.mark.parametrize("kind", ["FIFO", "socket", "device"])
def test_what_is_no_file_is_refused_and_not_waited_for(kind, tmp_path):
    path = tmp_path / "record.csv"
    if kind == "FIFO":
        os.mkfifo(path)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(str(path))
    else:
        path.symlink_to(os.devnull)
    for read in (sha256, read_bytes, lambda path: read_json(path, "mend it")):
        with pytest.raises(FreerockError, match=f"a {kind}, not a file"):
            read(path)
    with pytest.raises(FreerockError, match=f"is a {kind}, not a file; remove it"):
        look(path)
    with pytest.raises(FreerockError, match=f"is a {kind}, not a file; remove it"):
        read_record(path)


def test_a_file_half_written_alone_is_no_decision_on_two(tmp_path, monkeypatch):
    """The log of a look, killed while it was written, is not taken for the second half of a save."""
    table, log = tmp_path / "table", tmp_path / "log"
    for path in (table, log):
        path.write_bytes(b"old")

    def killed(*_):
        raise SystemExit

    monkeypatch.setattr(os, "fsync", killed)
    monkeypatch.setattr("freerock.files._drop", lambda paths: None)
    with pytest.raises(SystemExit):
        replace_together({log: b"new and lo"})
    monkeypatch.undo()
    recover([table, log])
    assert sorted((path.name, path.read_bytes()) for path in tmp_path.iterdir()) == [
        ("log", b"old"),
        ("table", b"old"),
    ]


@pytest.mark.parametrize("begun", [0, 1, 2, 3])
def test_files_replaced_together_are_all_new_or_all_old_after_a_kill(begun, tmp_path, monkeypatch):
    """Killed before the renaming of the first file, after it, and after that of the second."""
    paths = [tmp_path / name for name in "abc"]
    for path in paths:
        path.write_bytes(b"old")
    rename, left = os.replace, [begun]

    def killed(*names):
        if not left[0]:
            raise SystemExit
        left[0] -= 1
        rename(*names)

    monkeypatch.setattr(os, "replace", killed)
    monkeypatch.setattr("freerock.files._drop", lambda paths: None)  # nobody cleans up after a kill
    if begun < 3:
        with pytest.raises(SystemExit):
            replace_together(dict.fromkeys(paths, b"new"))
    else:
        replace_together(dict.fromkeys(paths, b"new"))
    monkeypatch.undo()
    recover(paths)
    assert {path.read_bytes() for path in paths} == {b"new" if begun else b"old"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b", "c"]
