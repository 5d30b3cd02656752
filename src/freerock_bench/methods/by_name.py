"""Every method by its name, freerock among them."""

import math
from collections.abc import Callable
from functools import partial

from freerock.arrays import Floats
from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate
from freerock_bench.methods.foundation import cyrk, fixed_step, scipy
from freerock_bench.methods.problem import Problem, Solution


def freerock(problem: Problem, time: Floats, rtol: float, limit: float = math.inf) -> Solution:
    """`freerock.models.simulate` on the problem. Parameters as in `scipy`; the limit counts steps."""
    response = simulate(
        problem.model,
        problem.block,
        problem.parameters,
        time,
        theta0=problem.theta0,
        rules=Rules(problem.debonding),
        solver=Solver(rtol, max_steps=int(min(limit, 2**31))),
    )
    outcome = "completed" if response.outcome == "at_rest" else response.outcome
    return Solution(response.theta, response.statistics["evaluations"], outcome)


Method = Callable[..., Solution]
METHODS: dict[str, Method] = {
    "freerock": freerock,
    **{
        f"SciPy {name}, {kind}": partial(scipy, name, kind == "numba")
        for kind in ("NumPy", "numba")
        for name in ("RK45", "DOP853", "LSODA", "Radau")
    },
    "CyRK RK45, law in Python": partial(cyrk, "RK45", False),
    **{f"CyRK {name}": partial(cyrk, name, True) for name in ("RK45", "DOP853", "LSODA", "RADAU")},
    "RK4": partial(fixed_step, "RK4"),
    "Newmark": partial(fixed_step, "Newmark"),
}
