import pandas as pd

from freerock.tables.markdown import markdown


def test_markdown_keeps_its_columns_whatever_the_cells_hold():
    text = markdown(pd.DataFrame({"a": ["1|2"], "b": ["3"]}), "Caption", ["A note."])
    lines = text.splitlines()
    assert lines[2:5] == ["| a | b |", "| --- | --- |", r"| 1\|2 | 3 |"]
    assert lines[-1] == "*A note.*"
