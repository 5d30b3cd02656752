"""Numbers of sentences looked up in the CSV files of a campaign, as somebody else would do it."""

import csv
import math
import re
from pathlib import Path

SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
PRINTED = re.compile(
    r"\(?(?P<value>[\d.−]+)( ± (?P<error>[\d.]+)\)?)?\)?(·10(?P<power>[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?( .*)?"
)


def found_again(findings, folder, labels):
    """Every number of findings: no digit stands outside of one, and each is what tables/ in `folder` holds.

    Returns how many numbers there were.
    """
    n = 0
    for finding in findings:
        for sentence in finding.sentences:
            words = " ".join(part for part in sentence if isinstance(part, str))
            for label in labels.values():
                words = words.replace(label, "")
            assert not re.search(r"\d", words), words
            for part in sentence:
                if not isinstance(part, str):
                    look_up(part, Path(folder))
                    n += 1
    return n


def look_up(number, folder):
    rows = [row for row in read(folder / f"{number.table}.csv") if holds(row, number.where)]
    printed = PRINTED.fullmatch(number.text)
    assert printed, number.text
    power = 10.0 ** int((printed["power"] or "0").translate(SUPERSCRIPTS))
    if number.how == "above":
        (row,) = rows
        assert float(row[number.columns[0]]) > float(number.text)
        return
    if number.how == "rows":
        known = [float(len(rows))]
    elif number.how == "distinct":
        known = [float(len({tuple(row[column] for column in number.columns) for row in rows}))]
    elif number.how == "value":
        (row,) = rows
        known = [float(row[column]) for column in number.columns]
    else:
        values = [float(row[number.columns[0]]) for row in rows if row[number.columns[0]]]
        if number.how in ("smallest", "largest"):
            values = list(map(abs, values))
        known = [{"lowest": min, "highest": max, "smallest": min, "largest": max}[number.how](values)]
    texts = [printed["value"], *([printed["error"]] if printed["error"] else [])]
    for text, value in zip(texts, known, strict=False):
        digits = len(text.partition(".")[2])
        shown = float(text.translate(SUPERSCRIPTS)) * power / number.factor
        assert math.isclose(shown, value, abs_tol=0.5001 * 10.0**-digits * power / number.factor), number


def holds(row, where):
    def one(name, value):
        if isinstance(value, tuple):
            return row[name] in value
        if str(value).startswith("!"):
            return row[name] != str(value)[1:]
        return row[name] != "" if value == "*" else row[name] == str(value)

    return all(one(name, value) for name, value in where.items())


def read(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
