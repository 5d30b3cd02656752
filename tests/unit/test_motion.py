"""Runs of a record as fits take them."""

from fabricated import failed_record, record

from freerock.products.runs import motions_in, runs_in


def test_a_motion_per_run_since_its_release():
    tree = record("b1_marble")
    motions = motions_in(tree, tree.dataset)
    assert list(motions) == [run.number for run in runs_in(tree)]
    for run in runs_in(tree):
        motion = motions[run.number]
        assert 0 <= motion.time_s[0] < motion.time_s[1]
        assert motion.time_s[-1] <= run.end_s - run.release_s
        assert len(motion.theta) == len(motion.time_s)
        assert motion.theta0 == run.theta0


def test_a_record_that_could_not_be_processed_has_none():
    assert motions_in(failed_record(), failed_record().dataset) == {}
