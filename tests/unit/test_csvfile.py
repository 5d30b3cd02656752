import numpy as np
import pandas as pd
import pytest

from freerock.errors import FreerockError
from freerock.tables.csvfile import read_csv, write_csv


def test_csv_bytes_are_the_same_and_no_temporary_file_stays(tmp_path):
    frame = pd.DataFrame({"x": [1 / 3, np.nan], "y": ["a", "b"]})
    for name in ("one.csv", "two.csv"):
        write_csv(frame, tmp_path / name)
    assert (tmp_path / "one.csv").read_bytes() == b"x,y\n0.3333333333,a\n,b\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.csv", "two.csv"]
    assert (tmp_path / "two.csv").read_bytes() == (tmp_path / "one.csv").read_bytes()


def test_names_of_digits_stay_names(tmp_path):
    frame = pd.DataFrame({"test": ["001", "02"], "run": [1, 2], "block": ["1", "2"], "r": [0.9, 0.8]})
    write_csv(frame, tmp_path / "names.csv")
    again = read_csv(tmp_path / "names.csv")
    assert again[["test", "run", "block"]].values.tolist() == [["001", "1", "1"], ["02", "2", "2"]]
    assert again["r"].tolist() == [0.9, 0.8]


def test_a_table_that_is_gone_is_one_line(tmp_path):
    with pytest.raises(FreerockError, match=r"gone\.csv: there is no such file; run snakemake again"):
        read_csv(tmp_path / "gone.csv")
