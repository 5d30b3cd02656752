"""The report of a made-up campaign, and its page taken apart."""

from html.parser import HTMLParser
from pathlib import Path

import numpy as np
from fabricated import tidy_tables
from matplotlib.image import imsave

from freerock.columns import columns_of
from freerock.config.campaign import load_campaign
from freerock.models.block import Block
from freerock.report.page import write_report
from freerock.tables.csvfile import read_csv, write_csv
from freerock.tables.paper import summary_table, table1, table2, table3

PUBLISHED = {"b1": {"marble": {"housner": {"r": 0.958, "epsilon_theta": 0.1525}}}}
BLOCKS = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
VOID = {"img", "meta", "br", "hr", "link", "input"}
SHIPPED = Path(__file__).parents[2] / "config/campaigns/palermo_virtual.yaml"


class Outline(HTMLParser):
    """Tags, attributes and text of a page; complains about tags that do not pair."""

    def __init__(self, html):
        super().__init__()
        self.html, self.open, self.tags, self.words, self.scripts = html, [], [], [], []
        self.feed(html)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID and not self.get_starttag_text().endswith("/>"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] == ["script"]:
            self.scripts.append(data)
        elif self.open[-1:] != ["style"]:
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def settings(trees, **changes):
    """The shipped campaign's section, for made-up records."""
    config = load_campaign(SHIPPED).model_dump(mode="json")
    shape = {"height_m": 0.28, "width_m": 0.07, "mass_kg": 5.84, "release_angle_deg": 10.0}
    line = dict.fromkeys(("channel", "exclude", "override", "reason", "note"), "") | {"laser": "at_200mm"}
    config |= {
        "title": "Marble & <mats>",
        "summary": "Two blocks.",
        "raw": "raw",
        "blocks": {"b1": {**shape, "label": "Slender"}, "b2": {**shape, "label": "Squat"}},
        "foundations": {"marble": {"label": "Marble"}, "mat": {"label": "Soft mat"}},
        "records": [
            line
            | {key: tree.attrs[key] for key in ("test", "block", "foundation")}
            | {"file": f"{tree.attrs['test']}.tdms"}
            for tree in trees
        ],
    }
    return config | changes


def tables_of(folder, datasets, shapes=BLOCKS):
    """Write the tables of made-up records into a folder; the frames by name."""
    records, fitted = datasets
    frames = tidy_tables(records, fitted)
    own = frames["choice"].query("status == 'selected'").assign(peak=1, peak_deg=8.0, inside=True, n_runs=1)
    frames["predictions"] = own.reindex(columns=columns_of("predictions"))
    frames["summary"] = summary_table(frames)
    frames |= {
        "table1": table1(records, shapes, {"b1": 10.0}),
        "table2": table2(frames["populations"], frames["paper"], frames["choice"], PUBLISHED),
        "table3": table3(frames["paper"], PUBLISHED),
    }
    for name, frame in frames.items():
        write_csv(frame, folder / f"{name}.csv")
    return {name: read_csv(folder / f"{name}.csv") for name in frames}


def make(folder, datasets, *, shapes=BLOCKS, figures=None, by_hand=(), **changes):
    """The report of made-up records, taken apart."""
    records, _ = datasets
    image = folder / "image.png"
    imsave(image, np.zeros((24, 30, 3)))
    write_report(
        folder / "report.html",
        provenance={
            "inputs": {"raw/b1_marble.tdms": "0a1b"},
            "config": settings(records, **changes),
            "software": {"numpy": "2.0"},
            "git": "abc-dirty",
        },
        tables=tables_of(folder, datasets, shapes),
        rates_hz=[950.0],
        figures=[("Rotation", image)] if figures is None else figures,
        pages={records[0].attrs["test"]: folder / "figures/qc.png"},
        changes=by_hand,
        texts=folder / "methods",
    )
    return Outline((folder / "report.html").read_text(encoding="utf-8"))
