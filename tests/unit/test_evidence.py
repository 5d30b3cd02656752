"""What the report says of made-up evidence, word for word."""

from evidence import NAMED, PIVOTING, POSSIBLE, REJECTED, paper, scene

from freerock.models.block import Block
from freerock.report.scene_choices import unexplained
from freerock.report.scene_evidence import explained, scenes_of, together
from freerock.selection.allowed_hypotheses import NOT_TRIED
from freerock.selection.choice import Evidence
from freerock.tables.candidates import candidates_table

BLOCKS = {"b1": Block(0.28, 0.07, 5.84)}
SMALLEST = "its residual is the noise of the sensor at rest, and no smaller law does as well."
TABLE2 = "These runs give no reason to quote k and λ of the other laws."
ALONE = "No other candidate that was fitted explains a run."
GUIDED = "k of Hunt–Crossley holds for a base whose centre moves up and down only (guided)"
HUNT = "Hunt–Crossley, k = 6.88·10⁶ N m⁻², λ = 1.30·10⁸ N s m⁻³"


def told(*runs, **options):
    choice, parameters = scene(*runs, **options)
    (found,) = scenes_of(choice, candidates_table(choice, parameters), BLOCKS, {"b1": "Slender"})
    assert found["name"] == "Slender on marble"
    return found


def test_a_rigid_block_on_sharp_corners():
    run = paper() | {"housner": NAMED}
    assert told(run, run, run)["sentences"] == [
        f"Housner explains all 3 runs: {SMALLEST}",
        ALONE,
        f"So this is a rigid block on a rigid foundation: r = 0.950. {TABLE2}",
    ]


def test_a_campaign_of_rigid_blocks_alone_has_no_k():
    choice, parameters = scene(paper() | {"housner": NAMED})
    choice = choice[choice["model"].isin(["housner", "housner_width"])]  # fits.models: [housner]
    (found,) = scenes_of(choice, candidates_table(choice, parameters), BLOCKS, {})
    assert found["sentences"][-1] == "So this is a rigid block on a rigid foundation: r = 0.950."


def test_worn_corners_of_a_rigid_block_are_no_foundation():
    run = paper(housner_width=NAMED)
    assert told(run, run)["sentences"] == [
        f"Housner, width free explains both runs: {SMALLEST}",
        ALONE,
        "So this is a rigid block whose edges are not where its width says, as worn corners make it: "
        f"r = 0.950, 2b = 0.0630 m, 90 % of the block's. {TABLE2}",
    ]


def test_worn_corners_or_a_compliant_foundation():
    run = paper(housner_width=NAMED) | {"hunt_crossley": POSSIBLE}
    sentences = told(run, paper(housner_width=NAMED))["sentences"]
    assert sentences[1] == "The data can't tell it from Hunt–Crossley (in 1 of 2 runs)."
    assert sentences[2] == (
        "1 of 2 runs can be a rigid block with worn corners (r = 0.950, 2b = 0.0630 m, 90 % of the block's) "
        f"as well as a block on a compliant foundation ({HUNT}): these data don't tell. Measure the contact "
        "width of the corners, or release from other angles, before you quote k and λ."
    )


def test_a_guided_foundation_where_pivoting_was_asked():
    run = paper(housner_width=REJECTED, hunt_crossley_pivoting=REJECTED) | {"hunt_crossley": NAMED}
    found = told(run)
    assert found["sentences"] == [
        f"Hunt–Crossley explains the run: {SMALLEST}",
        ALONE,
        "A rigid block with worn corners does not explain it.",
        f"{GUIDED}. A block that turns about the corner that stays down (pivoting) does not explain as "
        "much with as few parameters.",
    ]
    (left_out,) = found["left_out"]
    assert left_out.startswith("Not tried because a smaller candidate explains the run: General; ")
    assert "pivoting," in left_out


def test_worn_corners_that_the_data_tell_apart():
    choice, parameters = scene(paper(housner_width=REJECTED) | {"hunt_crossley": NAMED})
    choice.loc[choice["model"] == "housner_width", "explains"] = True
    (found,) = scenes_of(choice, candidates_table(choice, parameters), BLOCKS, {})
    larger = "No other candidate that was fitted explains as much with as few parameters."
    assert found["sentences"][1] == larger
    assert found["sentences"][2] == (
        "A rigid block with worn corners would leave no more than noise in the run as well, but the data "
        "tell it apart: its BIC is higher by more than 10."
    )


def test_a_guided_foundation_where_pivoting_was_not_asked():
    choice, parameters = scene(paper() | {"hunt_crossley": NAMED})
    choice = choice[~choice["model"].isin(PIVOTING)]  # fits.kinematics: [guided]
    (found,) = scenes_of(choice, candidates_table(choice, parameters), BLOCKS, {})
    assert found["sentences"][-1] == (
        f"{GUIDED}. A block that turns about the corner that stays down (pivoting) was not fitted; its "
        "k would be another."
    )


def test_a_quick_fit_is_asked_too():
    """It frees as many numbers as the one that explains the run, and has no full fit."""
    found = told(paper() | {"hunt_crossley": NAMED})
    assert "Winkler, pivoting" in [row[0].text for row in found["rows"]]
    assert found["sentences"][-1].endswith("(pivoting) does not explain as much with as few parameters.")


def test_a_candidate_that_was_never_tried_is_not_ruled_out_by_a_quick_fit():
    """It frees as many numbers as the one that explains the run, but the search never came to it."""
    choice, parameters = scene(paper() | {"hunt_crossley": NAMED})
    why = f"{NOT_TRIED}no candidate that it extends has a good enough fit"
    choice.loc[choice["model"] == "winkler_pivoting", "reason"] = why
    scenes = scenes_of(choice, candidates_table(choice, parameters), BLOCKS, {})
    quick, first, other = (note for _, note in together(scenes)["notes"])
    assert quick == "A quick fit, to fewer samples, rules out: Hunt–Crossley, pivoting; Housner, width free."
    assert first == "Not tried because no candidate that it extends has a good enough fit: Winkler, pivoting."
    assert other.startswith("Not tried because a smaller candidate explains the run: General; ")
    choice.loc[choice["model"] == "hunt_crossley_pivoting", "reason"] = why
    (found,) = scenes_of(choice, candidates_table(choice, parameters), BLOCKS, {})
    assert found["sentences"][-1].endswith("(pivoting) was not fitted; its k would be another.")


def test_a_pivoting_foundation_is_not_that_of_table_2():
    run = paper(hunt_crossley_pivoting=NAMED)
    assert told(run, k_hunt_crossley_pivoting=8.6e6)["sentences"][-1] == (
        "The block turns about the corner that stays down (pivoting): quote Hunt–Crossley, pivoting. "
        "k and λ of laws in which the base's centre moves up and down only are not those of this foundation."
    )


def test_guided_or_pivoting():
    run = paper(winkler_pivoting=POSSIBLE) | {"winkler": NAMED}
    assert told(run, k_winkler_pivoting=8.6e6)["sentences"][-1] == (
        "These data don't tell whether the base's centre moves up and down only (guided) or the block turns "
        "about the corner that stays down (pivoting), and k depends on it: Winkler, k = 6.88·10⁶ N m⁻², "
        "c = 2.36·10⁴ N s m⁻²; Winkler, pivoting, k = 8.60·10⁶ N m⁻², c = 2.36·10⁴ N s m⁻²."
    )


def test_runs_that_need_different_candidates():
    first, other = paper() | {"winkler": NAMED}, paper() | {"hunt_crossley": NAMED}
    assert told(first, other, other)["sentences"][0] == (
        "No one candidate is the smallest for all runs: Winkler explains 1 of 3, Hunt–Crossley 2 of 3."
    )


def test_no_candidate_explains_any_run():
    run = paper(housner_width=REJECTED) | {"hunt_crossley": NAMED}
    found = told(run, run, explained=False, epsilon=0.02)
    assert found["sentences"] == [
        "No candidate explains any of the 2 runs: each leaves more than the sensor shows at rest.",
        "The nearest is Hunt–Crossley; its parameters depend on how much of a run is fitted, and their "
        "standard errors don't say how wrong it is.",
        "Both a rigid block with worn corners (Housner, width free, ε_θ = 2.00 %) and a compliant foundation "
        "(Winkler, ε_θ = 2.00 %) come as near as published fits do (ε_θ up to 5 %): nearness does not "
        "show which of them it is.",
    ]
    statuses = {row[0].text: row[1].text for row in found["rows"]}
    assert statuses["Hunt–Crossley"] == "nearest in 2"
    assert statuses["Housner, width free"] == statuses["Winkler"] == "rejected in 2"
    assert [row[0].text for row in found["rows"] if row[0].kind == "warn"] == ["Hunt–Crossley"]
    assert found["left_out"] == []
    assert unexplained(scene(run, run, explained=False)[0]) == "No candidate explains both runs."


def test_a_run_of_which_none_is_named():
    found = told(paper(), paper() | {"winkler": NAMED})
    assert found["sentences"][1:3] == [
        "No candidate explains 1 of 2 runs: each leaves more than the sensor shows at rest.",
        "For 1 of 2 runs none is near enough to be selected.",
    ]
    assert (
        unexplained(scene(paper(), paper() | {"winkler": NAMED})[0]) == "No candidate explains 1 of 2 runs."
    )
    assert unexplained(scene(paper() | {"winkler": NAMED})[0]) == ""


def test_table_of_the_evidence():
    run = paper() | {"hunt_crossley": NAMED}
    rows = told(run, paper() | {"winkler": NAMED})["rows"]
    loud = "30.0 times at 1.00–2.00 Hz (p = 1.0·10⁻⁸)"
    fitted = [row for row in rows if row[1].text != "not fitted in 2"]
    assert [[cell.text for cell in row] for row in fitted] == [
        [name, runs, freed, "0.00100", "0.00200", bic, loud, why]
        for name, runs, freed, bic, why in (  # the rivals of as many numbers follow
            ("Housner", "rejected in 2", "3", "−15", "rejected housner"),
            ("Winkler", "selected in 1, rejected in 1", "4", "−5", "rejected winkler"),
            ("Hunt–Crossley", "selected in 1, rejected in 1", "4", "5", "rejected hunt_crossley"),
        )
    ]
    assert [row[0].kind for row in fitted] == ["", "named", "named"]
    assert [row[0].text for row in rows if row not in fitted] == [
        "Winkler, pivoting",
        "Hunt–Crossley, pivoting",
        "Housner, width free",
    ]


def test_numbers_of_a_candidate_are_of_the_fits_that_may_be_used_where_any_may():
    choice, parameters = scene(*[paper() | {"hunt_crossley": NAMED}] * 3)
    own = choice["model"] == "housner"
    choice.loc[own, "noise_ratio"] = [900.0, 40.0, 50.0]
    choice.loc[own, "bic"] = [1000.0, 120.0, 140.0]  # of the law that is named 20

    def shown(*runs):
        lost = {("t1", str(run), "housner") for run in runs}
        (found,) = scenes_of(choice, candidates_table(choice, parameters), BLOCKS, {}, lost)
        (row,) = [row for row in found["rows"] if row[0].text == "Housner"]
        return [row[i].text.partition(" at")[0] for i in (5, 6)]

    assert shown(1) == ["110", "50.0 times"]
    assert shown(1, 2, 3) == shown() == ["120", "900 times"]


def test_a_reason_without_its_numbers_is_whole():
    choice, parameters = scene(paper() | {"hunt_crossley": NAMED})
    rejected = Evidence("winkler", 4, success=True, epsilon_holdout=1.8).objection
    choice.loc[choice["model"] == "winkler", "reason"] = rejected
    (found,) = scenes_of(choice, candidates_table(choice, parameters), BLOCKS, {})
    (row,) = [row for row in found["rows"] if row[0].text == "Winkler"]
    assert row[-1].text == "held-out ε_θ is worse than that of a block at rest"


def test_what_scenes_share_is_told_once():
    found = told(paper(housner_width=REJECTED) | {"hunt_crossley": NAMED})
    whole = together([found, found | {"name": "Squat on marble"}])
    assert whole["told"] == [("Each block and foundation", found["sentences"])]
    assert [len(rows) for rows in whole["rows"]] == [4, 4]
    assert not any(row[1].text.startswith("not fitted") for rows in whole["rows"] for row in rows)
    assert [note.partition(":")[0] for _, note in whole["notes"]] == [
        "A quick fit, to fewer samples, rules out",
        "Not tried because a smaller candidate explains the run",
    ]
    apart = together(
        [found, found | {"name": "Squat on marble", "sentences": ["Otherwise."], "left_out": []}]
    )
    assert [names for names, _ in apart["told"]] == ["Slender on marble", "Squat on marble"]
    assert apart["notes"][-1][0] == "Slender on marble"


def test_the_table_of_scenes_has_no_column_of_dashes():
    def table(*runs):
        choice, parameters = scene(*runs)
        return explained(scenes_of(choice, candidates_table(choice, parameters), BLOCKS, {}))

    alone = table(paper() | {"hunt_crossley": NAMED})
    assert alone.heads == ["Block, foundation", "Runs explained", "Selected", "Medians"]
    assert [len(row) for row in alone.rows] == [4]
    assert alone.notes == [
        "Medians are over the runs that the model explains. Each row leads to its evidence."
    ]
    beside = table(
        paper() | {"hunt_crossley": NAMED, "winkler": POSSIBLE}, paper() | {"hunt_crossley": NAMED}
    )
    assert beside.heads[-1] == "As good" and beside.rows[0][-1].text == "Winkler (1)"
    assert beside.notes[0].startswith("In brackets") and beside.notes[0].endswith("the selected one.")


def test_a_chance_is_a_bound_near_nothing_and_near_one():
    choice, parameters = scene(paper() | {"hunt_crossley": NAMED})
    choice = choice.assign(noise_ratio=1.5)
    for p, text in ((0.999, "p > 0.99"), (0.5, "p = 0.50"), (1e-12, "p < 10⁻⁹")):
        own = choice.assign(noise_p=p)
        (found,) = scenes_of(own, candidates_table(own, parameters), BLOCKS, {})
        assert found["rows"][0][6].text.endswith(f"({text})")
