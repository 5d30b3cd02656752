"""Steps have names: as targets, and for --set-resources; a new line of the CSV reruns its own batch."""

import re

import pytest
from small_campaign import CAMPAIGN, add_campaign, check_out

from freerock.jobs.batches import batches

TESTS = [f"r{number:02d}" for number in range(24)]
SHOW = """\
include: "Snakefile"

for rule in workflow.rules:
    mb = rule.resources.get("mem_mb")
    print(rule.name, None if mb is None or mb.is_evaluable() else mb.value)
"""


@pytest.fixture
def many(tmp_path):
    """A campaign of many records, not analysed."""
    checkout = check_out(tmp_path / "many")
    yaml = CAMPAIGN.replace("truth: truth.json\n", "").replace("records_per_job: 1", "records_per_job: 5")
    add_campaign(checkout, "many", yaml, [(test, "", "tall") for test in TESTS])
    (checkout / "raw/many").mkdir(parents=True)
    for test in [*TESTS, "added"]:
        (checkout / f"raw/many/{test}.tdms").touch()
    return checkout


def outputs(checkout, *arguments):
    """The records of each job of a plan."""
    done = checkout.snakemake("--dry-run", *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    lists = re.findall(r"Reason: Missing output files: (.*?)(?:;|$)", done.stdout + done.stderr, re.M)
    return {frozenset(re.findall(r"records/(\w+)\.nc", each)) for each in lists}


def test_a_step_is_a_target(finished):
    for step, product in {"record": "records", "fit": "fits", "quality": "figures/qc_"}.items():
        done = finished.snakemake("--dry-run", "--forceall", step)
        made = set(re.findall(r"^(\w+?)_small-(\w+_mat) ", done.stdout + done.stderr, re.M))
        steps = ["record", "fit", "quality"][: ["record", "fit", "quality"].index(step) + 1]
        assert made == {(each, f"{block}_mat") for each in steps for block in ("tall", "squat")}, product


def test_resources_of_a_step(many):
    (many / "show").write_text(SHOW)
    done = many.snakemake(
        "--dry-run", "--quiet", "all", "-s", "show", "fit", "--set-resources", "fit:mem_mb=4321"
    )
    shown = dict(re.findall(r"^((?:record|fit|quality)_many-\w+) (\w+)$", done.stdout + done.stderr, re.M))
    number = len(batches(TESTS, 5))
    assert len(shown) == 3 * number
    assert {name.split("_")[0] for name, mb in shown.items() if mb == "4321"} == {"fit"}
    assert list(shown.values()).count("4321") == number


def test_an_expression_as_a_resource_of_a_step(many):
    done = many.snakemake("--dry-run", "fit", "--set-resources", "fit:mem_mb=attempt*1234", "fit:part='x'")
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"^ *resources: .*part=x, mem_mb=1234\b", done.stdout + done.stderr, re.M)


def test_names_that_look_alike_when_joined(many):
    for name, test in (("lab", "a_b"), ("lab_a", "b")):
        yaml = CAMPAIGN.replace("truth: truth.json\n", "").replace("records_per_job: 1", "records_per_job: 5")
        add_campaign(many, name, yaml, [(test, "", "tall")])
        (many / f"raw/{name}").mkdir(parents=True)
        (many / f"raw/{name}/{test}.tdms").touch()
    assert outputs(many, "--config", "campaigns=lab,lab_a", "--", "record") == {
        frozenset({"a_b"}),
        frozenset({"b"}),
    }


@pytest.mark.parametrize("place", [0, 11, 24])
def test_a_line_inserted_reruns_its_own_batch(many, place):
    before = outputs(many, "record")
    assert before == {frozenset(batch) for batch in batches(TESTS, 5)}
    lines = (many / "config/campaigns/many.csv").read_text().splitlines(keepends=True)
    lines.insert(1 + place, "added,added.tdms,,tall,mat,high,,,,\n")
    (many / "config/campaigns/many.csv").write_text("".join(lines))
    after = outputs(many, "record")
    changed = before - after
    assert len(changed) <= 1
    assert frozenset.union(*(after - before)) == frozenset({"added"}).union(*changed)
