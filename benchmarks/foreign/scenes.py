"""The foreign records: block, what it stands on, what is foreign to every law of freerock, what is known.

A block A, B or C, four ways to move it (planar, rigid, mujoco, drake), and for the score: which
candidates are a right choice, and true values where they mean something.
"""

import math

import numpy as np
import planar

BLOCKS = {
    "A": {"height_m": 0.30, "width_m": 0.08, "mass_kg": 5.0},
    "B": {"height_m": 0.45, "width_m": 0.09, "mass_kg": 8.0},
    "C": {"height_m": 0.20, "width_m": 0.10, "mass_kg": 4.5},
}
LASERS = {"A": (0.20, 0.1), "B": (0.25, 0.1), "C": (0.12, 0.1)}  # height, range [m]
DEPTH_M = 0.12
ANGLES = {"A": (0.10, -0.08), "B": (0.08, 0.06), "C": (-0.20, 0.17)}  # of the two releases [rad]
STONE, MAT = {"k": 7e6, "lambda": 2e8}, {"k": 2.5e6, "lambda": 5e7}
ON_BED = ("hunt_crossley", "hunt_crossley_pivoting")
LOAD, FLOOR_W = 2 * math.pi * 9, 2 * math.pi * 12  # [rad/s]


def _bed(of, about, soil, choices=(), base=None, known=("k",), block=(), formats="tdms", **extra):
    """A block on Hunt and Crossley's bed with something besides."""
    width = BLOCKS[of]["width_m"]
    return {
        "about": about,
        "block": of,
        "motion": "planar",
        "law": planar.HUNT_CROSSLEY,
        "values": [soil["k"], soil["lambda"]],
        "base": base or planar.flat(width),
        "off": dict(block),
        "extra": extra,
        "truth": {name: soil[name] for name in known},
        "choices": list(choices),
        "free_s": 8.0 if soil is STONE else 6.0,
        "format": formats,
    }


def _other(of, about, law, values, free_s=8.0, formats="tdms", **extra):
    """A block on a bed of another law."""
    soil = {"k": values[0], "lambda": 0.0}
    made = _bed(of, about, soil, known=(), formats=formats, **extra)
    return made | {"law": law, "values": list(values), "free_s": free_s}


def _rigid(of, about, restitution, choices=(), radius=0.0, formats="tdms"):
    return {
        "about": about,
        "block": of,
        "motion": "rigid",
        "restitution": restitution,
        "radius": radius,
        "truth": {},
        "choices": list(choices),
        "free_s": 7.0,
        "format": formats,
    }


def _engine(of, about, motion, free_s=6.0, formats="tdms", **setting):
    return {
        "about": about,
        "block": of,
        "motion": motion,
        "setting": {"crooked": 0.0, "mu": 0.7, "depth_m": DEPTH_M, **setting},
        "truth": {},
        "choices": [],
        "free_s": free_s,
        "format": formats,
    }


def _feet(width_m, foot_m):
    u, w, slope, share = planar.flat(width_m, 100)
    keep = np.abs(u) > width_m / 2 - foot_m
    return u[keep], w[keep], slope[keep], share[keep]


def _hollow(width_m, depth_m):
    """A base that is hollow in the middle: deepest there, level at the edges."""
    u, _, _, share = planar.flat(width_m, 100)
    b = width_m / 2
    return u, depth_m * (1 - (u / b) ** 2), -2 * depth_m * u / b**2, share


def _stepped(width_m, from_m, depth_m):
    """The base lies higher from one place on to the right."""
    u, _, slope, share = planar.flat(width_m, 80)
    return u, np.where(u > from_m, depth_m, 0.0), slope, share


def _cracked(width_m, from_m, to_m):
    """Nothing below the base from one place to another."""
    u, w, slope, share = planar.flat(width_m, 80)
    keep = (u < from_m) | (u > to_m)
    return u[keep], w[keep], slope[keep], share[keep]


def by_speed(rate):
    """Restitution that falls with the rate."""
    return 0.985 - 0.08 * abs(rate)


def by_side(rate):
    """Restitution that differs between the two edges."""
    return 0.95 if rate > 0 else 0.90


def constant(rate):
    """Restitution of rounded edges."""
    return 0.93


M_A = BLOCKS["A"]["mass_kg"]
CRACKED = _cracked(0.08, 0.024, 0.028)
SCENES = {
    "friction_stone": _bed("A", "base held by friction alone", STONE, ON_BED, known=STONE),
    "friction_mat": _bed("C", "base held by friction alone", MAT, ON_BED, known=MAT, formats="csv"),
    "slips_stone": _bed("A", "slips on stone, μ = 0.15", STONE, mu=0.15),
    "slips_mat": _bed("C", "slips on a mat, μ = 0.3", MAT, mu=0.3, formats="h5"),
    "rounded_1mm": _bed(
        "A",
        "edges rounded by 1 mm",
        STONE,
        ON_BED,
        planar.rounded(0.08, 1e-3, 200),
        known=STONE,
    ),
    "rounded_4mm": _bed("B", "edges rounded by 4 mm", MAT, ON_BED, planar.rounded(0.09, 4e-3, 180)),
    "two_feet_stone": _bed("A", "rocks on two feet of 12 mm", STONE, base=_feet(0.08, 0.012)),
    "two_feet_mat": _bed("C", "rocks on two feet of 20 mm", MAT, base=_feet(0.10, 0.02), formats="mat"),
    "hollow_base": _bed("B", "base hollow by 0.1 mm", STONE, base=_hollow(0.09, 1e-4)),
    "stepped_base": _bed("A", "0.3 mm lower from 20 mm on", STONE, base=_stepped(0.08, 0.02, 3e-4)),
    "cracked_base": _bed("A", "a crack of 4 mm in the mat", MAT, base=CRACKED),
    "centre_off_mat": _bed("A", "centre of mass 1.5 mm off", MAT, ON_BED, block={"centre_off_m": 1.5e-3}),
    "centre_off_stone": _bed(
        "B",
        "centre of mass 0.5 mm off",
        STONE,
        ON_BED,
        block={"centre_off_m": 5e-4},
        formats="csv",
    ),
    "off_level": _bed("C", "base off level by 0.3°", STONE, ON_BED, tilt=math.radians(0.3)),
    "mat_creeps": _other(
        "A",
        "mat that creeps and stays dented",
        planar.CREEP,
        (2e6, 2e6, 0.02, 2.5e3, 3e7),
    ),
    "mat_relaxes": _other("B", "mat that relaxes within 10 ms", planar.CREEP, (2e6, 3e6, 0.01, 1e12, 1.0)),
    "damping_by_depth": _other(
        "A", "damping by the square of the depth", planar.DEPTH_DAMPING, (7e6, 4e11), formats="h5"
    ),
    "hertz": _other("C", "force by the depth to the 1.5", planar.HERTZ, (1e8, 2e9)),
    "hysteresis": _other("B", "stiffer when it is let off than when pressed", planar.HYSTERESIS, (4e6, 5e6)),
    "cable": _bed("A", "a cable rubs against turning", STONE, ON_BED, drag=0.005 * M_A * 9.81 * 0.04),
    "loose_load": _bed(
        "A",
        "a load of 0.2 kg on a spring of 9 Hz",
        STONE,
        load_m=0.2,
        load_k=0.2 * LOAD**2,
        load_c=0.02 * LOAD,
        load_up=0.08,
    ),
    "floor_shakes": _bed("B", "floor that shakes at 12 Hz", MAT, ON_BED, floor_a=0.05, floor_w=FLOOR_W),
    "rigid_by_speed": _rigid("A", "r falls with the rate", by_speed),
    "rigid_by_side": _rigid("C", "r is 0.95 at one edge, 0.90 at the other", by_side, formats="mat"),
    "rigid_rolls": _rigid("B", "rolls over edges of 6 mm", constant, radius=6e-3),
    "mujoco_box": _engine("A", "MuJoCo's box with friction", "mujoco", contact=[0.004, 0.3]),
    "mujoco_crooked": _engine(
        "A", "MuJoCo's box, let go crooked by 2°", "mujoco", contact=[0.004, 0.3], crooked=math.radians(2)
    ),
    "drake_crooked": _engine(
        "C",
        "Drake's box on four feet, let go crooked by 1°",
        "drake",
        stiffness=2e5,
        dissipation=3.0,
        step_s=5e-4,
        crooked=math.radians(1),
    ),
    "drake_field": _engine(
        "B",
        "Drake's box, hydroelastic contact",
        "drake",
        modulus=2e6,
        dissipation=15.0,
        step_s=1e-3,
        formats="csv",
    ),
}
