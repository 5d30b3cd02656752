"""Cells of a campaign's CSV file are changed; all other lines stay."""

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from freerock.errors import FreerockError
from freerock.review.csv_edit import edited

HEAD = "test,file,channel,block,foundation,laser,exclude,override,reason,note"
ROW = "{0},{0}.tdms,,tall,mat,high,{1},{2},{3},{4}"
ONE, TWO, THREE = (ROW.format(name, "", "", "", "") for name in ("one", "two", "three"))


def lines(*rows, end="\n", last=True):
    return end.join([HEAD, *rows]) + (end if last else "")


# Name, file, and what the line of `two` becomes in it when run 2 is excluded as it "slipped, a little".
AWKWARD = {
    "plain": (lines(ONE, TWO, THREE), TWO, 'two,two.tdms,,tall,mat,high,2,,"slipped, a little",'),
    "bom crlf": (
        "\ufeff" + lines(ONE, TWO, end="\r\n"),
        TWO,
        'two,two.tdms,,tall,mat,high,2,,"slipped, a little",',
    ),
    "comments": (
        f"# our tests\n{HEAD}\n  # two, in vain\n{ONE}\n#{TWO}\n{TWO}\n# end",
        f"\n{TWO}\n# end",
        '\ntwo,two.tdms,,tall,mat,high,2,,"slipped, a little",\n# end',
    ),
    "quoted commas": (
        lines(ONE, 'two,"a, b.tdms",,tall,mat,high,,,,"said ""ok"", then left"'),
        'two,"a, b.tdms",,tall,mat,high,,,,"said ""ok"", then left"',
        'two,"a, b.tdms",,tall,mat,high,2,,"slipped, a little","said ""ok"", then left"',
    ),
    "other order": (
        f"reason,exclude,test,file,block,foundation,laser\n,,one,1.tdms,tall,mat,high\n{',,two,2.tdms,tall,mat,high'}\n",
        ",,two,2.tdms,tall,mat,high",
        '"slipped, a little",2,two,2.tdms,tall,mat,high',
    ),
    "no such columns, comments": (
        "test,file\r\n# a, b\r\none,1\r\n\r\ntwo,2",
        "test,file\r\n# a, b\r\none,1\r\n\r\ntwo,2",
        'test,file,exclude,reason\r\n# a, b\r\none,1,,\r\n\r\ntwo,2,2,"slipped, a little"',
    ),
    "a name that begins another": (
        lines(ONE, ROW.format("two_b", "", "", "", ""), TWO, ROW.format("two_c", "", "", "", "")),
        f"\n{TWO}\n",
        '\ntwo,two.tdms,,tall,mat,high,2,,"slipped, a little",\n',
    ),
}
EDITS = [("two", "exclude", "2"), ("two", "reason", "slipped, a little")]


@pytest.mark.parametrize("name", AWKWARD)
def test_only_the_cells_that_change_change(name):
    text, before, after = AWKWARD[name]
    assert text.count(before) == 1
    assert edited(text.encode(), EDITS).decode() == text.replace(before, after)


CELL = st.text(st.sampled_from('ab,;"# \u2028é\t'), max_size=6)


@pytest.mark.slow
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
        made = edited(content, [("t0", "note", value)])
    except FreerockError as error:
        assert "control character" in str(error)
        return
    rows = list(csv.reader(io.StringIO(made.decode(), newline=""), strict=True))
    expected = [["test", "note", "more"], *([f"t{i}", *row] for i, row in enumerate(cells))]
    expected[1] = ["t0", value.strip(), expected[1][2].strip()]
    assert [rows[1][0], rows[1][1].strip(), rows[1][2].strip()] == expected[1]
    assert rows[:1] + rows[2:] == expected[:1] + expected[2:]


REFUSED = {
    "no such record": (
        lines(ONE),
        "CSV: there is no record 'two'; read the file again and choose another record",
    ),
    "twice": (lines(TWO, TWO), "CSV: 'two' is there twice; read the file again and choose another record"),
    "open quote": (lines('one,"'), "CSV:2: unexpected end of data; check the quotes"),
    "text after a quote": (lines('"one"x,'), "CSV:2: ',' expected after '\"'; check the quotes"),
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
