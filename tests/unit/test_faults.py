"""Faults as a reader sees them."""

import numpy as np

from freerock.rotation.flags import FLAGS, flagged_faults

TIME = 5e-4 * np.arange(8000)


def test_near_stretches_are_one_fault():
    flags = np.zeros(TIME.size, np.uint8)
    flags[100:105] = flags[110:112] = flags[1000] = FLAGS["spike"]
    flags[102] |= FLAGS["out_of_range"]
    assert [(f.name, f.start_s, f.end_s, f.note) for f in flagged_faults(TIME, flags)] == [
        ("out_of_range", TIME[102], TIME[102], "1 sample"),
        ("spike", TIME[100], TIME[111], "7 samples"),
        ("spike", TIME[1000], TIME[1000], "1 sample"),
    ]
