"""OpenSees: a block of stiff corotational beams on gap springs with dashpots (ViscoelasticGap).

The dashpot may pull while the gap is closed: the geometric rule. The base centre is guided.
"""

import math
from itertools import pairwise

import openseespy.opensees as ops
from driver import answer, places, steps, substeps

MOST_HALVINGS = 8
AXIAL, BENDING = 1e10, 1e8  # of the beams [N, N m²]: rigid to within 1e-9 rad


def prepare(scene, setting):
    """Setting: springs, step_s, and alpha of HHT or none for Newmark's average acceleration."""
    b, h, m, theta, z0 = (scene[name] for name in ("b", "h", "m", "theta0", "z0"))
    us, width = places(scene, setting["springs"])
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    ops.geomTransf("Corotational", 1)
    ops.uniaxialMaterial("ViscoelasticGap", 1, scene["k"] * width, scene["c"] * width, -1e-12)
    # beams along the base keep the matrix's band narrow; nodes 1 and 2: its centre and the centre of mass
    nodes = {1: (0.0, 0.0), 2: (0.0, h)} | {10 + i: (u, 0.0) for i, u in enumerate(us)}
    for tag, (x, y) in nodes.items():
        ops.node(tag, x, y)
    ops.fix(1, 1, 0, 0)
    ops.mass(2, m, m, m * (b * b + h * h) / 3)
    along = sorted((x, tag) for tag, (x, y) in nodes.items() if y == 0)
    beams = [(1, 2), *((one, other) for (_, one), (_, other) in pairwise(along))]
    for element, (one, other) in enumerate(beams, 1):
        ops.element("elasticBeamColumn", element, one, other, AXIAL, 1.0, BENDING, 1)
    for i, u in enumerate(us):
        ops.node(10000 + i, u, 0.0)
        ops.fix(10000 + i, 1, 1, 1)
        ops.element("zeroLength", 10000 + i, 10000 + i, 10 + i, "-mat", 1, "-dir", 2)
    for tag, (x, y) in nodes.items():
        right = x * math.cos(theta) + y * math.sin(theta) - x
        up = -x * math.sin(theta) + y * math.cos(theta) - z0 - y
        for direction, value in enumerate((right, up, -theta), 1):
            ops.setNodeDisp(tag, direction, value, "-commit")
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(2, 0.0, -m * scene["g"], 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-10, 50)
    ops.algorithm("Newton")
    if setting.get("alpha"):
        ops.integrator("HHT", setting["alpha"])
    else:
        ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")

    def run():
        found = [theta]
        for _ in range(steps(scene)):
            for _ in range(substeps(scene, setting["step_s"])):
                _advance(setting["step_s"])
            found.append(-ops.nodeDisp(1, 3))
        return found

    return run


def _advance(step_s, halved=0):
    """A step; where springs open and close for ever in Newton's iteration, two of half its length."""
    if ops.analyze(1, step_s) == 0:
        return
    if halved == MOST_HALVINGS:
        raise ArithmeticError("Newton's iteration does not converge")
    for _ in range(2):
        _advance(step_s / 2, halved + 1)


answer(prepare)
