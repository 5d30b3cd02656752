import pandas as pd

from freerock.tables.markdown import markdown


def test_markdown_keeps_its_columns_whatever_the_cells_hold():
    text = markdown(pd.DataFrame({"a": ["1|2"], "b": ["3"]}), "Caption", ["A note."])
    lines = text.splitlines()
    assert lines[2:5] == ["| a | b |", "| --- | --- |", r"| 1\|2 | 3 |"]
    assert lines[-1] == "*A note.*"


def test_no_cell_is_read_as_html_or_markdown():
    cells = ["<b>& < 4.3", "two\nlines", "[x](y) `z` *w* ~v~", "back\\|slash"]
    text = markdown(pd.DataFrame([cells], columns=["a", "b", "c", "d"]), "<i>Caption")
    assert text.splitlines()[0] == "**&lt;i&gt;Caption**"
    assert text.splitlines()[-1] == (
        r"| &lt;b&gt;&amp; < 4.3 | two lines | \[x\](y) \`z\` \*w\* \~v\~ | back\\\|slash |"
    )
