"""The report of a made-up campaign, and its page taken apart."""

from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
from fabricated import fits, record, tidy_tables
from matplotlib.image import imsave

from freerock.config.campaign import load_campaign
from freerock.models.block import Block
from freerock.populations.predict import PREDICTIONS
from freerock.products.estimates import estimates_of
from freerock.report.page import write_report
from freerock.tables.csvfile import read_csv, write_csv
from freerock.tables.populations import budget_table, foundations_table, populations_table
from freerock.tables.restitution_comparison import restitution_comparison
from freerock.tables.summary import table1, table2, table3
from freerock.tables.tidy_tables import CONTRIBUTIONS

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


def predicted(estimates):
    """Discrepancies as predictions would have them, of made-up size: of other runs, and of another block."""
    rows = [
        [each.campaign, each.test, each.run, each.block, each.foundation, each.model, basis, 1, epsilon]
        for i, each in enumerate(estimates)
        for basis, epsilon in (("other runs", 0.001 * (1 + i)), ("b2", 0.01 * (1 + i)))
    ]
    return pd.DataFrame(rows, columns=PREDICTIONS)


def tables_of(folder, datasets, shapes=BLOCKS):
    """Write the tables of made-up records into a folder; their names."""
    records, fitted = datasets
    tidy = tidy_tables(records, fitted)
    known = (tidy[name] for name in ("runs", "populations", "restitution"))
    frames = tidy | {"restitution_comparison": restitution_comparison(*known, shapes)}
    frames["foundations"] = foundations_table(frames["populations"])
    frames["predictions"] = predicted(estimates_of(fitted))
    frames |= {
        "table1": table1(records, shapes),
        "table2": table2(tidy["populations"], tidy["parameters"], choice=tidy["choice"]),
    }
    frames["table3"] = table3(tidy["epsilon"], choice=tidy["choice"])
    for name, frame in frames.items():
        write_csv(frame, folder / f"{name}.csv")
    return list(frames)


def half_explained(folder):
    """Tables of two blocks on marble: the law that explains the runs of one is rejected for the other."""
    trees = [record("b1_marble"), record("b2_marble", "b2", n_runs=1)]
    names = tables_of(folder, (trees, [fits(tree) for tree in trees]))
    frames = {name: read_csv(folder / f"{name}.csv") for name in names}
    choice, parameters = frames["choice"], frames["parameters"]
    of_b2 = choice["block"] == "b2"
    choice.loc[of_b2, ["status", "explains"]] = "rejected", False
    choice.loc[of_b2 & (choice["model"] == "winkler"), "status"] = "selected"  # the nearest
    nothing = pd.DataFrame(columns=CONTRIBUTIONS)
    frames["populations"] = populations_table(parameters, nothing, choice)
    frames["budget"] = budget_table(parameters, nothing, choice)
    for name in ("choice", "populations", "budget"):
        write_csv(frames[name], folder / f"{name}.csv")
    return {name: read_csv(folder / f"{name}.csv") for name in names}


def make(folder, datasets, *, shapes=BLOCKS, figures=None, by_hand=(), **changes):
    records, fitted = datasets
    pairs = {pair[0].attrs["test"]: pair for pair in zip(records, fitted, strict=True)}
    image = folder / "image.png"
    imsave(image, np.zeros((24, 30, 3)))
    frames = tables_of(folder, datasets, shapes)
    write_report(
        folder / "report.html",
        provenance={
            "inputs": {"raw/b1_marble.tdms": "0a1b"},
            "config": settings(records, **changes),
            "software": {"numpy": "2.0"},
            "git": "abc-dirty",
        },
        tables={name: read_csv(folder / f"{name}.csv") for name in frames},
        blocks=shapes,
        opened=lambda test, samples: pairs[test],
        figures=[("Rotation", image)] if figures is None else figures,
        pages={records[0].attrs["test"]: folder / "figures/qc.png"},
        changes=by_hand,
        texts=folder / "methods",
    )
    return Outline((folder / "report.html").read_text(encoding="utf-8"))
