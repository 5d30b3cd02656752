"""The second simulator, compiled by one process of a run of the tests and loaded by the others."""

import math

import pytest
from small_campaign import BLOCKS, MAT, once

from freerock_bench.springs import Motion, Scene


@pytest.fixture(scope="session", autouse=True)
def springs(tmp_path_factory):
    scene = Scene(BLOCKS["squat"][0], MAT, True, math.radians(10))
    once(tmp_path_factory, "springs", lambda folder: Motion(scene, 1000.0, 0.01))
