"""Golden solutions: scenes of rocking solved to twelve digits twice, and the score of anybody's solution."""
