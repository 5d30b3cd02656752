"""Every law and every parameter of a law has its entry in each table and figure that lists them."""

import numpy as np
import pytest

from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import LAWS
from freerock.models.simulate import simulate

OF_LAWS = {name for law in LAWS.values() for name in law.parameters}


def test_a_law_has_known_parameters():
    assert set(PARAMETERS) >= OF_LAWS


@pytest.mark.parametrize("model, name", [(model, name) for model, law in LAWS.items() for name in law.ratios])
def test_every_parameter_of_a_law_changes_its_motion(model, name):
    k, block, time = 7e6, Block(0.28, 0.07, 5.84), np.linspace(0, 2, 401)
    values = {each: 3 * PARAMETERS[each].trace for each in LAWS[model].parameters}
    values |= {"k": k, **{each: k * values[each] for each in LAWS[model].ratios}}
    with_it, without = (
        simulate(model, block, each, time, theta0=0.1).theta for each in (values, values | {name: 0.0})
    )
    assert np.abs(with_it - without).max() > 1e-4
