"""Makes a process that is soon over look for garbage seldom; to be imported before all else.

What modules bring stays to the end. Python would look through it again and again, and once more as it ends: a
quarter of a second of most jobs, a second of a fit.
"""

import atexit
import gc

gc.set_threshold(50_000)  # objects made since the last look, in place of 700: a few MB
atexit.register(gc.freeze)
