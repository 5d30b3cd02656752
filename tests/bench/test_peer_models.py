"""What the drivers of other engines hand over, to stand-ins: these engines are rarely installed."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from math import cos, sin
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock
from xml.etree import ElementTree

import numpy as np
import pytest

DRIVERS = Path(__file__).parents[2] / "benchmarks/peers"
SCENE = {"b": 0.035, "h": 0.14, "m": 5.84, "g": 9.8, "theta0": 0.1, "z0": 1e-4}
SCENE |= {"k": 7e6, "c": 2e4, "lambda": 1e8, "until_s": 0.02, "every_s": 0.01}
B, H, M, THETA0 = (SCENE[name] for name in ("b", "h", "m", "theta0"))
ABOUT = M * (B**2 + H**2) / 3
WIDE = 2 * B
N = 8  # strips of the base


@pytest.fixture
def driver(monkeypatch):
    """The function that loads a script, with modules in place of its engine's."""

    def load(name, **engine):
        for module, stand_in in engine.items():
            monkeypatch.setitem(sys.modules, module.replace("__", "."), stand_in)
        for each in ("driver", name):
            spec = spec_from_file_location(each, DRIVERS / f"{each}.py")
            module = module_from_spec(spec)
            monkeypatch.setitem(sys.modules, each, module)
            spec.loader.exec_module(module)
            module.answer = lambda prepare: None
        return module

    return load


def test_springs_of_opensees_are_the_whole_bed(driver):
    ops = MagicMock(**{"nodeDisp.return_value": -0.05, "analyze.return_value": 0})
    script = driver("opensees", openseespy=MagicMock(opensees=ops), openseespy__opensees=ops)
    run = script.prepare(SCENE, {"springs": N, "step_s": 0.0025})
    springs = [each.args for each in ops.element.call_args_list if each.args[0] == "zeroLength"]
    stiffness, damping = ops.uniaxialMaterial.call_args.args[2:4]
    assert len(springs) * stiffness == pytest.approx(SCENE["k"] * WIDE)
    assert len(springs) * damping == pytest.approx(SCENE["c"] * WIDE)
    assert ops.mass.call_args.args == (2, M, M, pytest.approx(ABOUT))
    assert ops.load.call_args.args == (2, 0.0, -M * SCENE["g"], 0.0)
    moved = {each.args[:2]: each.args[2] for each in ops.setNodeDisp.call_args_list}
    leans = {1: H * sin(THETA0), 2: H * cos(THETA0) - SCENE["z0"] - H, 3: -THETA0}
    assert {i: moved[2, i] for i in leans} == pytest.approx(leans)
    assert run() == [THETA0, 0.05, 0.05]
    assert [each.args for each in ops.analyze.call_args_list] == 8 * [(1, 0.0025)]


def test_contacts_of_mujoco_are_the_whole_bed(driver):
    weight = 0.17
    model = SimpleNamespace(body=lambda name: SimpleNamespace(id=0), body_invweight0=np.array([[weight, 1]]))
    model.geom_solimp, model.geom_solref = np.zeros((N + 1, 5)), np.zeros((N + 1, 2))
    data = SimpleNamespace(qpos=np.zeros(2))
    engine = MagicMock(**{"MjModel.from_xml_string.return_value": model, "MjData.return_value": data})
    script = driver("mujoco_strips", mujoco=engine)
    run = script.prepare(SCENE, {"strips": N, "step_s": 0.0025})
    tree = ElementTree.fromstring(engine.MjModel.from_xml_string.call_args.args[0])
    inertial = tree.find(".//inertial").attrib
    assert float(inertial["mass"]) == M and inertial["pos"] == f"0 0 {H}"
    assert float(inertial["diaginertia"].split()[1]) == pytest.approx(ABOUT)
    assert len(tree.findall(".//body/geom")) == N
    whole = -N * model.geom_solref / ((1 - script.IMPEDANCE) * weight)
    np.testing.assert_allclose(whole, np.tile([SCENE["k"] * WIDE, SCENE["c"] * WIDE], (N + 1, 1)))
    assert data.qpos.tolist() == [-SCENE["z0"], THETA0]
    assert run() == 3 * [THETA0] and engine.mj_step.call_count == 8


def test_contacts_of_drake_are_the_whole_bed(driver):
    plant, up, turn = MagicMock(), MagicMock(), MagicMock()
    plant.AddJoint.side_effect = [up, turn]
    modules = (
        "geometry",
        "math",
        "multibody__plant",
        "multibody__tree",
        "systems__analysis",
        "systems__framework",
    )
    engine = {f"pydrake__{name}": MagicMock() for name in modules} | {"pydrake": MagicMock()}
    tree = engine["pydrake__multibody__tree"]
    engine["pydrake__multibody__plant"].AddMultibodyPlantSceneGraph.return_value = plant, None
    driver("drake_points", **engine).prepare(SCENE, {"points": N})
    assert tree.RotationalInertia.call_args_list[0].args == pytest.approx((ABOUT, ABOUT, 1.5 * ABOUT))
    assert tree.SpatialInertia.MakeFromCentralInertia.call_args_list[0].args[0] == M
    told = engine["pydrake__geometry"].ProximityProperties.return_value.AddProperty.call_args_list
    values = {each.args[1]: each.args[2] for each in told}
    in_series = values["point_contact_stiffness"] / 2
    assert N * in_series == pytest.approx(SCENE["k"] * WIDE)
    assert values["hunt_crossley_dissipation"] == SCENE["lambda"] / SCENE["k"]
    assert (up.set_translation.call_args.args[1], turn.set_angle.call_args.args[1]) == (-SCENE["z0"], THETA0)
