"""docs/validation.md: sentences that repeat numbers of its tables."""

from pathlib import Path

from freerock_bench.document import marked

DOCS = Path(__file__).parents[2] / "docs"
TEXT = " ".join((DOCS / "validation.md").read_text(encoding="utf-8").split("\n"))


def rows(name):
    """Rows of a table that a study writes, as lists of cells."""
    lines = marked(DOCS / "validation.md", name)[1].splitlines()[2:]
    return [[cell.strip() for cell in line[1:-1].split("|")] for line in lines]


def test_false_alarms_are_those_of_the_noises():
    found = rows("noises")
    assert len(found) == 17
    records, failed, warned, in_doubt = (sum(int(row[i]) for row in found) for i in range(1, 5))
    assert failed == 0
    spaced = f"{records:,}".replace(",", " ")
    assert f"Of the {spaced} clean records under seventeen noises, none fails, {warned} are warned, " in TEXT
    assert f"and {in_doubt} true laws are in doubt." in TEXT
    louder = sum(int(row[4]) for row in found if row[0] in ("speckle by rate", "10 ms in motion"))
    stated = (
        "under [seventeen noises](validation.md#signals) "
        f"{in_doubt} of {spaced} records (noise louder in motion for {louder})"
    )
    assert stated in (DOCS / "identification.md").read_text(encoding="utf-8")


def test_missed_faults_are_those_of_the_kinds():
    found = {row[0].strip("*"): row for row in rows("kinds")}
    ok, warned, failed = (int(each) for each in found["others"][1:4])
    assert f"Of the {ok + warned + failed} faulty or unusual records " in TEXT
    unusual, beyond, far = (int(found[kinds][i] or 0) for kinds, i in (("others", 7), ("all", 7), ("all", 8)))
    assert f"{ok} are `ok`, and {unusual} of their numbers err beyond 2 u." in TEXT
    inside, known = map(int, found["all"][6].split(" of "))
    assert (
        f"{beyond} numbers of {found['all'][1]} `ok` records err beyond 2 u, {far} beyond 3 u; "
        f"{100 * inside / known:.0f} % of intervals hold truth"
    ) in TEXT
