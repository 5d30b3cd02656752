"""What the set-up compiles is all that an analysis calls."""

import subprocess
import sys
from pathlib import Path

import pytest

ANALYSED = """
from numba.core.dispatcher import Dispatcher

compiled, call = [], Dispatcher.compile
def noting(self, signature):
    compiled.append(self.py_func.__name__)
    return call(self, signature)
Dispatcher.compile = noting

from freerock.compile import compile_kernels
compile_kernels()
known = len(compiled)

import freerock
block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
laser = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)
record = freerock.load("raw/palermo_virtual/config2_marble.tdms", block, laser)
for law in ("housner", "winkler", "hunt_crossley_pivoting"):
    freerock.fit_record(law, block, dict([*record.motions.items()][:1]))
print(known > 0, compiled[known:])
"""


@pytest.mark.slow
def test_an_analysis_compiles_nothing_that_the_set_up_has_not():
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", ANALYSED], cwd=root, capture_output=True, text=True)
    assert done.stdout == "True []\n", done.stderr
