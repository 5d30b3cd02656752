"""Configurations, truths, tables and names of nonsense: each is taken or refused with a line, in little time.

python -m freerock_bench.fuzz_texts [number of each] [kind …]
"""

import json
import os
import random
import sys
import tempfile
import unicodedata
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "unit"))

from matplotlib.figure import Figure
from pandas import DataFrame
from records import damaged

from freerock.cli.inspect_command import look_text
from freerock.cli.new_campaign_command import new_campaign
from freerock.config import step_settings
from freerock.config.campaign import read_campaign
from freerock.config.mistakes import ConfigError
from freerock.errors import FreerockError
from freerock.figures.style import label, wrapped
from freerock.rotation.calibration import read_calibration
from freerock.tables.latex import latex
from freerock.tables.markdown import markdown
from freerock.virtual_lab.truth import read_truth
from freerock_bench.fuzz import tried

SMALL = """\
title: T
origin: measured
raw: R
blocks: {tall: {height_m: 0.28, width_m: 0.07, mass_kg: 5.84}}
foundations: {mat: {label: L}}
lasers: {near: {beam: horizontal, position_m: 0.1, range_m: 0.05}}
"""
HEADER = "test,file,channel,block,foundation,laser,exclude,override,reason,note"
LINE = f"{HEADER}\none,one.tdms,top,tall,mat,near,1,,why,wet\n"
SHIPPED = Path(__file__).parents[2]
YAML = (SHIPPED / "config/campaigns/palermo_virtual.yaml").read_bytes()
CSV = (SHIPPED / "config/campaigns/palermo_virtual.csv").read_bytes()
TRUTH = json.dumps({"one": {"model": "winkler", "runs": [{"k": 1e6, "c": 1e3}] * 3}}, indent=1).encode()
TABLE = b"V,mm\n" + b"".join(b"%d.5,%d\n" % (n, 5 * n) for n in range(11))
LONG = ("9" * 5000, "a" * 300, "_" * 50_000, " " * 5000, "[" * 5000)
LONG += ("{a: " * 2000, "\n" * 5000, "1," * 40_000)
MARKS = (*"[]{}:,;|>'\"#\n\t\r%@`!", ": ", "- ", "? ", "&a ")
WORDS = "*a|<<: *a|---|...|%YAML 1.1\n|!!int ''|!!bool x|!!timestamp x|!!python/name:os|=|~"
NUMBERS = "017 1:30 1_000 1e999 -1e999 .nan NaN -.inf Infinity 0x1f 5e-324 -0 true null"
SIGNS = (
    *"\x00\x85\u2028\ufeff\u202eéθ😀\\/",
    *["\x1b[31m", "$x_{$", "\\frac{$", "<b>", "{x}", "../", "=1+1"],
)
TOKENS = (*LONG, *(*MARKS, *WORDS.split("|"), *NUMBERS.split(), *SIGNS) * 8)


def spoilt(content: bytes, n: int) -> Iterator[bytes]:
    """Damaged copies of a text: half of them as of any file, half with tokens in it or in place of a word."""
    bytes_damaged = damaged(content, n, seed=1)
    for i in range(n):
        copy = next(bytes_damaged)
        if i % 2:
            draw, text = random.Random(i), content.decode()
            for _ in range(draw.randint(1, 3)):
                at = draw.randint(0, len(text))
                end = at + draw.choice([0, draw.randint(0, 12)])
                text = text[:at] + draw.choice(TOKENS) + text[end:]
            copy = text.encode("utf-8", "surrogatepass")
        yield copy


def written(path: Path, copies: Iterator[bytes]) -> Iterator[Path]:
    """Each copy in turn at one path."""
    for copy in copies:
        path.write_bytes(copy)
        yield path


def campaign(path: Path) -> None:
    """Read a campaign, and give its steps what they get of it."""
    source = read_campaign(path.with_suffix(".yaml"))
    if source.campaign is None:
        raise ConfigError(source.problems)
    settings = step_settings.record_settings(source.campaign, source.campaign.records, {})
    json.dumps([settings, step_settings.descriptions(source.campaign)], ensure_ascii=False).encode()


def names(n: int) -> Iterator[str]:
    """Texts of any characters."""
    for i in range(n):
        draw, parts = random.Random(i), []
        for _ in range(draw.randint(1, 7)):
            char = chr(draw.randrange(draw.choice([0x80, 0x250, 0x3000, 0x110000])))
            parts.append(draw.choice([char, draw.choice(TOKENS)]))
        yield "".join(parts)


def named(path: Path) -> None:
    """Use one text as every name and label that there is, and as that of a channel and of a file."""
    text = path.read_bytes().decode("utf-8", "surrogatepass")
    quoted, refused = json.dumps(text), []
    for old, new in (
        ("label: L", f"label: {quoted}"),
        ("tall:", f"{quoted}:"),
        ("title: T", f"title: {quoted}"),
        ("raw: R", f"raw: {quoted}"),
    ):
        refused += tried_in(path.parent, SMALL.replace(old, new), LINE)
    for cell in ("one", "one.tdms", "top", "why", "wet"):
        quoted = '"' + text.replace('"', '""') + '"'
        refused += tried_in(path.parent, SMALL, LINE.replace(cell, quoted, 1))
    channel(path.parent, text)
    if refused:
        raise refused[-1]


def tried_in(folder: Path, yaml: str, csv: str) -> list[FreerockError]:
    """Why a campaign is refused; a label of one that is not is drawn and printed."""
    (folder / "lab.yaml").write_bytes(yaml.encode("utf-8", "surrogatepass"))
    (folder / "lab.csv").write_bytes(csv.encode("utf-8", "surrogatepass"))
    try:
        campaign(folder / "lab.yaml")
    except FreerockError as error:
        return [error]
    text = read_campaign(folder / "lab.yaml").campaign.foundations["mat"].label
    if text != "L":
        drawn(text)
    return []


def drawn(text: str) -> None:
    """Show a label wherever labels are shown."""
    figure = Figure()
    ax = figure.subplots()
    ax.plot([0, 1], label=label({"a": text}, "a"))
    ax.set_title(wrapped(label({"a": text}, "a"), 0.5))
    ax.legend()
    figure.draw_without_rendering()
    for printed in (markdown, latex):
        lines = [printed(DataFrame({"": [cell]}), cell).count("\n") for cell in (text, "x")]
        assert lines[0] == lines[1]


def channel(folder: Path, text: str) -> None:
    """Read a record with a channel of that name, and begin a campaign with a file of that name."""
    stick = folder / "stick"
    stick.mkdir(exist_ok=True)
    heading = text.replace('"', "'").replace("\n", " ").replace("\r", " ")[:1000]
    rows = "".join(f"{i / 100},{i % 7}\n" for i in range(50))
    content = f'time [s],"{heading}"\n{rows}'.encode("utf-8", "surrogatepass")
    name = text.encode("utf-8", "surrogatepass")[:200].replace(b"/", b"_").replace(b"\0", b"")
    odd = Path(os.fsdecode(os.fsencode(stick) + b"/" + name + b".csv"))
    odd.write_bytes(content)
    (stick / "usual.csv").write_bytes(content)
    drawing = nullcontext() if len(text) % 20 == 0 else patch("freerock.cli.new_campaign_command.draw_looks")
    with tempfile.TemporaryDirectory(dir=folder) as root, drawing:  # a picture takes as long as all else
        try:
            made = new_campaign("lab", stick, root)
        except FreerockError as error:
            assert "\n" not in str(error)
        else:
            told = "".join(map(look_text, made.looks)) + "".join(map(str, made.refused))
            assert not any(unicodedata.category(char) in ("Cc", "Cs") and char != "\n" for char in told)
            assert all(
                " is still to be filled in; " in str(each) for each in read_campaign(made.yaml).problems
            )
        finally:
            odd.unlink()


def kinds(folder: Path, n: int) -> dict[str, tuple[Iterator[Path], Callable[[Path], object]]]:
    """Of each kind its files and what takes them."""
    (folder / "yaml").mkdir()
    (folder / "csv").mkdir()
    (folder / "yaml/lab.csv").write_bytes(CSV)
    (folder / "csv/lab.yaml").write_bytes(YAML)
    texts = (text.encode("utf-8", "surrogatepass") for text in names(n))
    return {
        "yaml": (written(folder / "yaml/lab.yaml", spoilt(YAML, n)), campaign),
        "csv": (written(folder / "csv/lab.csv", spoilt(CSV, n)), campaign),
        "truth": (written(folder / "truth.json", spoilt(TRUTH, n)), read_truth),
        "table": (written(folder / "table.csv", spoilt(TABLE, n)), read_calibration),
        "names": (written(folder / "name.txt", texts), named),
    }


def main(n: int, chosen: list[str]) -> int:
    """Try so many of each kind; return how many were neither taken nor refused."""
    with tempfile.TemporaryDirectory() as folder:
        found = kinds(Path(folder), n)
        return sum(tried(kind, *(found[kind][0], n, found[kind][1])) for kind in chosen or found)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000, sys.argv[2:]) > 0)
