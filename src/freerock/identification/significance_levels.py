"""Levels of the tests on a run, in one place: from how many tests a campaign makes.

A campaign of a hundred clean runs makes three tests of each that may reject the law that is named: the
residual against the noise at rest, the pulls of its inputs, and the number that the law lacks. Each law that
is rejected by chance alone should be seen in one of twenty such campaigns (Bonferroni).
"""

NORMAL_95 = 1.959963984540054  # standard errors to either side of a 95 % interval
REJECTS = 0.05 / (3 * 100)  # 1.7e-4: pulls at which a law is rejected
# Chance of the residual as `goodness` has it. That is an upper bound, since sensors may be
# a tenth louder than at rest: of 1 400 clean runs of seven noises none lies below it.
RESIDUAL = 1e-3
PULLED = 2.0  # standard deviations from which the shift of an input is noted
# Chance of so large a pull of any input, from which the note is a warning: 2e-3, one clean run of 500. At one
# of 200, two of 309 clean records were warned of it; with what else may warn, that is more than one of 200.
WARNS = 0.2 / 100
TELLS = 10.0  # difference of the BIC from which the data tell two candidates apart
