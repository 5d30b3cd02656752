"""Values printed in Spanos et al. 2017, doi:10.1016/j.proeng.2017.09.024."""

import math

from freerock.models.block import Block

BLOCKS = {  # table 1: height and width [m], mass [kg]
    "config1": Block(0.42, 0.07, 8.67),
    "config2": Block(0.28, 0.07, 5.84),
    "config3": Block(0.14, 0.07, 2.98),
}
RELEASE_ANGLES = dict(zip(BLOCKS, map(math.radians, (6, 10, 20)), strict=True))  # table 1 [rad]
TABLE_2 = {  # parameters of configuration 2 [SI]
    "marble": {
        "housner": {"r": 0.958},
        "winkler": {"k": 6.77e6, "c": 2.17e4},
        "hunt_crossley": {"k": 6.88e6, "lambda": 1.30e8},
    },
    "aerstop": {
        "housner": {"r": 0.895},
        "winkler": {"k": 4.50e6, "c": 4.05e4},
        "hunt_crossley": {"k": 2.86e6, "lambda": 8.16e7},
    },
}
TABLE_3 = {  # ε_θ of configuration 2, as fractions
    "marble": {"housner": 0.1525, "winkler": 0.0245, "hunt_crossley": 0.0140},
    "aerstop": {"housner": 0.2166, "winkler": 0.0458, "hunt_crossley": 0.0287},
}
PUBLISHED_BLOCK = "config2"  # of tables 2 and 3
