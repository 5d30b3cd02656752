"""Which differences between blocks on one foundation are seen, and how often there is none that is seen?"""

import numpy as np
import pandas as pd

from freerock.identification.population import SIGNIFICANT, between_blocks
from freerock.studies.virtual_run import SEED

DRAWS = {"full": 4000, "small": 20}  # of each case
SIZES = ((2, 3), (2, 5), (3, 3), (3, 5), (3, 10))  # blocks, runs of each
DIFFERENCES = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)  # of ln k, in spreads between runs
CORRELATION = 0.8  # of ln k and ln λ from run to run
SPREADS = {"alike": (1.0, 1.0, 1.0), "unlike": (0.5, 1.0, 2.0)}  # between the runs of each block


def run(size: str = "full") -> pd.DataFrame:
    """Blocks whose k and λ scatter from run to run, the last of which has another k and λ.

    Parameters
    ----------
    size : str
        "full", or "small" for seconds.

    Returns
    -------
    pandas.DataFrame
        A row per case: spreads ("alike" of all blocks, or "unlike"), n_blocks, n_runs (of each), difference
        (of ln k and ln λ of the last block, in mean spreads between runs), n_draws, seen (share of draws in
        which p is below 5 %).
    """
    rows = []
    for case, (name, spreads) in enumerate(SPREADS.items()):
        for n_blocks, n_runs in SIZES:
            for difference in DIFFERENCES if name == "alike" else (0.0,):
                key = [SEED, case, n_blocks, n_runs, int(10 * difference)]
                generator, seen = np.random.default_rng(key), 0
                half = np.linalg.cholesky([[1.0, CORRELATION], [CORRELATION, 1.0]])
                for _ in range(DRAWS[size]):
                    blocks = [
                        spread * generator.standard_normal((n_runs, 2)) @ half.T
                        for spread in spreads[:n_blocks]
                    ]
                    blocks[-1] = blocks[-1] + difference
                    seen += between_blocks(blocks).p < SIGNIFICANT
                rows.append((name, n_blocks, n_runs, difference, DRAWS[size], seen / DRAWS[size]))
    columns = ["spreads", "n_blocks", "n_runs", "difference", "n_draws", "seen"]
    return pd.DataFrame(rows, columns=columns)
