"""Times of calls on a machine that has other work too."""

import math
import time as clock
from collections.abc import Callable, Sequence
from typing import Any


def interleaved(
    calls: Sequence[Callable[[], Any]], rounds: int, longest_s: float = math.inf, in_a_row: int = 1
) -> list[tuple[Any, float, int]]:
    """Best time of each of several calls, run in turn so that they share the machine's bad moments.

    Parameters
    ----------
    calls : sequence of callable
        Without arguments. The first run of each, which may have to compile, counts only where it is not
        repeated.
    rounds : int
        Most runs of each after the first.
    longest_s : float
        A call is not repeated again once its runs have taken this long together [s], and not once where
        the first takes five times as long.
    in_a_row : int
        Runs of each in its turn: from the second on they find the caches as repeated runs do.

    Returns
    -------
    list of (result, float, int)
        Result, best time [s] and number of runs that count, of each. Time is that of the wall, or that of the
        processor where it is less: a long call on a busy machine waits for its turn.
    """
    results, spent = list[Any](), list[float]()
    for call in calls:
        made, elapsed = _timed(call)
        results.append(made)
        spent.append(elapsed)
    best, runs = list(spent), [0] * len(calls)
    for n in range(rounds):
        for i, call in enumerate(calls):
            if spent[i] > (longest_s if n else 5 * longest_s):
                continue
            for _ in range(in_a_row):
                _, elapsed = _timed(call)
                best[i] = min(best[i], elapsed) if runs[i] else elapsed
                spent[i], runs[i] = spent[i] + elapsed, runs[i] + 1
    return list(zip(results, best, (max(1, n) for n in runs), strict=True))


def _timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """Result of a call and its time [s]."""
    wall, processor = clock.perf_counter(), clock.process_time()
    made = call()
    return made, min(clock.perf_counter() - wall, clock.process_time() - processor)
