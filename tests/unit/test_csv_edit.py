"""Cells of a campaign's CSV file are changed; all other bytes stay."""

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from freerock.errors import FreerockError
from freerock.review.csv_edit import Edit, edited

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


# a file that others write as well
