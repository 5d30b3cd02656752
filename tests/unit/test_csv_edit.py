"""Cells of a campaign's CSV file are changed; all other bytes stay."""

import csv
import io
import os
import signal
import subprocess
import sys
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from freerock.config.record import read_records
from freerock.errors import FreerockError
from freerock.review.csv_edit import Edit, digest, edited, parsed, save_edits

HEAD = "test,file,channel,block,foundation,laser,exclude,override,reason,note"
ROW = "{0},{0}.tdms,,tall,mat,high,{1},{2},{3},{4}"
ONE, TWO, THREE = (ROW.format(name, "", "", "", "") for name in ("one", "two", "three"))


def lines(*rows, end="\n", last=True):
    return end.join([HEAD, *rows]) + (end if last else "")


# Name, file, and what the line of `two` becomes in it when run 2 is excluded as it "slipped, a little".
AWKWARD = {
    "plain": (lines(ONE, TWO, THREE), TWO, 'two,two.tdms,,tall,mat,high,2,,"slipped, a little",'),
    "crlf": (lines(ONE, TWO, THREE, end="\r\n"), TWO, 'two,two.tdms,,tall,mat,high,2,,"slipped, a little",'),
    "cr": (lines(ONE, TWO, THREE, end="\r"), TWO, 'two,two.tdms,,tall,mat,high,2,,"slipped, a little",'),
    "bom": ("\ufeff" + lines(ONE, TWO), TWO, 'two,two.tdms,,tall,mat,high,2,,"slipped, a little",'),
    "bom crlf": (
        "\ufeff" + lines(ONE, TWO, end="\r\n"),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "no last line end": (
        lines(ONE, TWO, last=False),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "mixed line ends": (
        f"{HEAD}\r\n{ONE}\n{TWO}\r{THREE}\r\n",
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "blank lines": (
        f"\n\n{HEAD}\n\n{ONE}\n\n\n{TWO}\n\n",
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "comments": (
        f"# our tests\n{HEAD}\n  # two, in vain\n{ONE}\n#{TWO}\n{TWO}\n# end",
        f"\n{TWO}\n# end",
        '\ntwo,two.tdms,,tall,mat,high,2,,"slipped, a little",\n# end',
    ),
    "quote in a comment": (
        f'{HEAD}\n# a 5" block\n{ONE}\n{TWO}\n',
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "quoted comment": (
        f'{HEAD}\n"# not now, ""please""",,,,,,,,,\n{TWO}\n',
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "all quoted": (
        f'{HEAD}\n{ONE}\n"two","two.tdms","","tall","mat","high","","","",""\n',
        '"two","two.tdms","","tall","mat","high","","","",""',
        '"two","two.tdms","","tall","mat","high","2","","slipped, a little",""',
    ),
    "quoted commas": (
        lines(ONE, 'two,"a, b.tdms",,tall,mat,high,,,,"said ""ok"", then left"'),
        'two,"a, b.tdms",,tall,mat,high,,,,"said ""ok"", then left"',
        'two,"a, b.tdms",,tall,mat,high,2,,"slipped, a little","said ""ok"", then left"',
    ),
    "line ends in quotes": (
        lines('one,one.tdms,,tall,mat,high,,,,"first\n# second\nthird"', TWO),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "quote within a cell": (
        lines('one,one.tdms,,tall,mat,high,,,,5" block', TWO),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "spaces": (
        lines(ONE, " two , two.tdms ,, tall , mat , high ,  ,  ,  , note "),
        " two , two.tdms ,, tall , mat , high ,  ,  ,  , note ",
        ' two , two.tdms ,, tall , mat , high ,2,  ,"slipped, a little", note ',
    ),
    "spaces around a value": (
        lines(ONE, "two,two.tdms,,tall,mat,high,  1  ,,bad,"),
        "two,two.tdms,,tall,mat,high,  1  ,,bad,",
        'two,two.tdms,,tall,mat,high,  2  ,,"slipped, a little",',
    ),
    "other order": (
        f"reason,exclude,test,file,block,foundation,laser\n,,one,1.tdms,tall,mat,high\n{',,two,2.tdms,tall,mat,high'}\n",
        ",,two,2.tdms,tall,mat,high",
        '"slipped, a little",2,two,2.tdms,tall,mat,high',
    ),
    "trailing columns": (
        f"{HEAD},who,when\n{ONE},AB,Monday\n{TWO},CD,Tuesday\n",
        f"{TWO},CD,Tuesday",
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",,CD,Tuesday',
    ),
    "no such columns": (
        "test,file,block,foundation,laser\none,1.tdms,tall,mat,high\ntwo,2.tdms,tall,mat,high\n",
        "laser\none,1.tdms,tall,mat,high\ntwo,2.tdms,tall,mat,high",
        'laser,exclude,reason\none,1.tdms,tall,mat,high,,\ntwo,2.tdms,tall,mat,high,2,"slipped, a little"',
    ),
    "no such column, the last cell empty": (
        "test,file,exclude\none,1,\ntwo,2,\n",
        "exclude\none,1,\ntwo,2,",
        'exclude,reason\none,1,,\ntwo,2,2,"slipped, a little"',
    ),
    "no such columns, comments": (
        "test,file\r\n# a, b\r\none,1\r\n\r\ntwo,2",
        "test,file\r\n# a, b\r\none,1\r\n\r\ntwo,2",
        'test,file,exclude,reason\r\n# a, b\r\none,1,,\r\n\r\ntwo,2,2,"slipped, a little"',
    ),
    "semicolons": (
        f"{HEAD};x\n{ONE};\n{TWO};\n".replace(",", ";"),
        f"{TWO};".replace(",", ";"),
        "two;two.tdms;;tall;mat;high;2;;slipped, a little;;",
    ),
    "tabs": (
        lines(ONE, TWO).replace(",", "\t"),
        TWO.replace(",", "\t"),
        "two\ttwo.tdms\t\ttall\tmat\thigh\t2\t\tslipped, a little\t",
    ),
    "lasers in one cell": (
        lines("one,1.tdms,a;b,tall,mat,high;low,,,,", "two,2.tdms,a;b,tall,mat,high;low,,,,"),
        "two,2.tdms,a;b,tall,mat,high;low,,,,",
        'two,2.tdms,a;b,tall,mat,high;low,2,,"slipped, a little",',
    ),
    "another alphabet": (
        lines("one,Ölbad θ.tdms,,tall,mat,high,,,,слева 左", TWO),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "hostile texts": (
        lines("one,1.tdms,,tall,mat,high,,,,<script>alert('x')</script>", TWO),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "a name that begins another": (
        lines(ONE, ROW.format("two_b", "", "", "", ""), TWO, ROW.format("two_c", "", "", "", "")),
        f"\n{TWO}\n",
        '\ntwo,two.tdms,,tall,mat,high,2,,"slipped, a little",\n',
    ),
    "excluded already": (
        lines(ONE, ROW.format("two", "1", "", '"fell, hard"', "")),
        'two,two.tdms,,tall,mat,high,1,,"fell, hard",',
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "quoted column names": (
        lines(ONE, TWO).replace("exclude,override", '"exclude", override'),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "rows of commas": (
        lines(ONE, ",,,,,,,,,", TWO),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "a thousand records": (
        lines(*(ROW.format(f"t{i}", "", "", "", "") for i in range(1000)), TWO),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
}
EDITS = [Edit("two", "exclude", "2"), Edit("two", "reason", "slipped, a little")]


@pytest.mark.parametrize("name", AWKWARD)
def test_only_the_cells_that_change_change(name):
    text, before, after = AWKWARD[name]
    assert text.count(before) == 1
    assert edited(text.encode(), EDITS).decode() == text.replace(before, after)


def test_there_are_thirty_awkward_files():
    assert len(AWKWARD) >= 30


@pytest.mark.parametrize("name", AWKWARD)
def test_nothing_changed_is_the_same_file(name):
    content = AWKWARD[name][0].encode()
    table = parsed(content)
    same = [
        Edit(test, column, table.value(test, column)) for test in table.rows for column in ("file", "test")
    ]
    assert edited(content, [edit for edit in same if "\n" not in edit.value]) == content


@pytest.mark.parametrize("name", AWKWARD)
def test_back_and_forth_leaves_what_was_there(name):
    """Undone, each cell holds what it held; a cell whose quotes were not needed may have lost them."""
    content = AWKWARD[name][0].encode()
    table = parsed(content)
    back = [Edit("two", edit.column, table.value("two", edit.column)) for edit in EDITS]
    again = parsed(edited(edited(content, EDITS), back))
    for test in table.rows:
        for column in (cell.value for cell in table.header):
            assert again.value(test, column) == table.value(test, column)


def test_bytes_that_are_no_utf8_stay():
    content = lines("one,1.tdms,,tall,mat,high,,,,caf\xe9", TWO).encode("latin-1")
    assert b"caf\xe9" in edited(content, EDITS)


@pytest.mark.parametrize("name", [name for name in AWKWARD if name not in ("semicolons", "tabs")])
def test_cells_are_those_that_the_configuration_reads(name, tmp_path):
    """Where the file is a sound campaign's, both read the same records."""
    path = tmp_path / "c.csv"
    path.write_bytes(edited(AWKWARD[name][0].encode(), EDITS))
    table, problems = parsed(path.read_bytes()), []
    records = read_records(path, {key: None for key in ("block", "foundation", "laser")}, path, problems)
    for _, record in records:
        for column in ("exclude", "reason", "file"):
            assert " ".join(table.value(record.test, column).split()) == getattr(record, column)


CELL = st.text(st.sampled_from('ab,;"# \n\u2028é\t'), max_size=6)


@given(
    st.lists(st.tuples(CELL, CELL), min_size=1, max_size=4),
    st.sampled_from(["\n", "\r\n"]),
    st.text(max_size=5),
)
def test_whatever_a_file_holds_only_one_cell_changes(cells, end, value):
    """Against Python's csv module as a second reader."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator=end)
    writer.writerow(["test", "note", "more"])
    writer.writerows([f"t{i}", *row] for i, row in enumerate(cells))
    content = out.getvalue().encode()
    try:
        made = edited(content, [Edit("t0", "note", value)])
    except FreerockError as error:
        assert "control character" in str(error)
        return
    rows = list(csv.reader(io.StringIO(made.decode(), newline=""), strict=True))
    expected = [["test", "note", "more"], *([f"t{i}", *row] for i, row in enumerate(cells))]
    rows[1][1], expected[1][1] = rows[1][1].strip(), value.strip()
    assert rows == expected


REFUSED = {
    "no such record": (
        lines(ONE),
        "CSV: there is no record 'two'; read the file again and choose another record",
    ),
    "twice": (lines(TWO, TWO), "CSV: 'two' is there twice; read the file again and choose another record"),
    "open quote": (lines('one,"'), "CSV:2: a quote is not closed; check the quotes"),
    "text after a quote": (lines('"one"x,'), "CSV:2: text follows a closed quote; check the quotes"),
    "too few cells": (
        lines("# a", "two,x"),
        "CSV:3: has 2 cells, the first line has 10; give the missing ones, even if empty",
    ),
    "no names": ("", "CSV: has no column test; write the line of column names first"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name):
    text, told = REFUSED[name]
    with pytest.raises(FreerockError) as error:
        edited(text.encode(), EDITS)
    assert str(error.value) == told


@pytest.mark.parametrize("value", ["two\nlines", "a\x00b", "a\u2028b", "\x1b[31m"])
def test_a_value_is_one_line_of_text(value):
    with pytest.raises(FreerockError, match="the note of two would hold a line break or another control"):
        edited(lines(TWO).encode(), [Edit("two", "note", value)])


# a file that others write as well


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "campaign.csv"
    path.write_text(lines(ONE, TWO))
    return path


def test_the_second_of_two_editors_is_told_and_nothing_is_lost(path):
    known = digest(path.read_bytes())
    save_edits(path, known, [Edit("one", "note", "by the first")])
    after = path.read_bytes()
    with pytest.raises(FreerockError, match="was changed by someone else since it was read; read the file"):
        save_edits(path, known, EDITS)
    assert path.read_bytes() == after
    save_edits(path, digest(after), EDITS)
    table = parsed(path.read_bytes())
    assert (table.value("one", "note"), table.value("two", "exclude")) == ("by the first", "2")


SAVES = """\
import sys
from pathlib import Path
from freerock.errors import FreerockError
from freerock.review.csv_edit import Edit, digest, parsed, save_edits
path, name = Path(sys.argv[1]), sys.argv[2]
for i in range(50):
    while True:
        content = path.read_bytes()
        try:
            n = int(parsed(content).value(name, "note") or 0) + 1
            save_edits(path, digest(content), [Edit(name, "note", str(n))])
            break
        except FreerockError as error:
            assert "someone else" in str(error)
"""


def test_no_change_of_editors_at_once_is_lost(path):
    both = [subprocess.Popen([sys.executable, "-c", SAVES, str(path), name]) for name in ("one", "two")]
    assert [each.wait(60) for each in both] == [0, 0]
    table = parsed(path.read_bytes())
    assert [table.value(name, "note") for name in ("one", "two")] == ["50", "50"]
    assert [file.name for file in path.parent.iterdir()] == ["campaign.csv"]


FOREVER = SAVES.replace("range(50)", "iter(int, 1)")


def test_killed_while_it_saves_the_file_is_the_old_or_the_new_one(path):
    path.write_text(lines(*(ROW.format(f"t{i}", "", "", "", "x" * 90) for i in range(2000)), TWO))
    for i in range(8):
        before = path.read_bytes()
        writer = subprocess.Popen([sys.executable, "-c", FOREVER, str(path), "two"])
        until = time.monotonic() + 20
        while path.read_bytes() == before and time.monotonic() < until:
            time.sleep(0.01)
        time.sleep(0.013 * i)
        os.kill(writer.pid, signal.SIGKILL)
        writer.wait()
        table = parsed(path.read_bytes())
        assert len(table.rows) == 2001
        note = table.value("two", "note")
        assert path.read_text() == lines(
            *(ROW.format(f"t{i}", "", "", "", "x" * 90) for i in range(2000)), TWO + note
        )
        assert int(note) > 0


def test_rights_and_links_stay(path, tmp_path):
    path.chmod(0o640)
    link = tmp_path / "link.csv"
    link.symlink_to(path)
    save_edits(link, digest(path.read_bytes()), EDITS)
    assert link.is_symlink()
    assert path.stat().st_mode & 0o777 == 0o640
    assert b"slipped" in path.read_bytes()
