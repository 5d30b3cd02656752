"""Renew the golden solutions: `python -m freerock_bench.golden [FOLDER [SPAN_S]]`."""

import sys
from pathlib import Path

from freerock_bench.golden import files, make
from freerock_bench.golden.scenes import SPAN_S

folder = Path(sys.argv[1]) if len(sys.argv) > 1 else files.SOLUTIONS
span_s = float(sys.argv[2]) if len(sys.argv) > 2 else SPAN_S
files.write(make.run(span_s), folder)
