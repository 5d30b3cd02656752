"""Drake: a box in space with friction, on four feet or with its hydroelastic contact."""

import engine
import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    HalfSpace,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    ContactModel,
    CoulombFriction,
    DiscreteContactApproximation,
    ExternallyAppliedSpatialForce,
)
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

FOOT_M = 0.005


def main(scene):
    """The motion of a scene."""
    b, h, d = scene["width_m"] / 2, scene["height_m"] / 2, scene["depth_m"] / 2
    builder, step_s = DiagramBuilder(), scene["step_s"]
    plant, _ = AddMultibodyPlantSceneGraph(builder, step_s)
    inertia = SpatialInertia(scene["mass_kg"], np.zeros(3), UnitInertia.SolidBox(2 * b, 2 * d, 2 * h))
    block = plant.AddRigidBody("block", inertia)
    friction = CoulombFriction(scene["mu"], scene["mu"])

    def material(compliant):
        properties = ProximityProperties()
        if "modulus" in scene:
            if compliant:
                AddCompliantHydroelasticProperties(b / 4, scene["modulus"], properties)
            else:
                AddRigidHydroelasticProperties(properties)
            AddContactMaterial(scene["dissipation"] if compliant else 0.0, None, friction, properties)
        else:
            AddContactMaterial(scene["dissipation"], 2 * scene["stiffness"], friction, properties)
        return properties

    if "modulus" in scene:
        plant.set_contact_model(ContactModel.kHydroelasticWithFallback)
        plant.RegisterCollisionGeometry(
            block, RigidTransform(), Box(2 * b, 2 * d, 2 * h), "box", material(True)
        )
    else:
        for i, (x, y) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1))):
            place = RigidTransform([x * (b - FOOT_M), y * (d - FOOT_M), FOOT_M - h])
            plant.RegisterCollisionGeometry(block, place, Sphere(FOOT_M), f"foot {i}", material(True))
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "ground", material(False)
    )
    plant.Finalize()
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(context, block, RigidTransform([0.0, 0.0, h]))
    push = ExternallyAppliedSpatialForce()
    push.body_index, push.p_BoBq_B = block.index(), np.zeros(3)
    port, rows = plant.get_applied_spatial_force_input_port(), []
    simulator.Initialize()
    each, held = round(1e-3 / step_s), False
    for i in range(round(scene["until_s"] / step_s)):
        angle, grip = engine.wanted(i * step_s, scene["runs"])
        if grip or held or i % each == 0 or not i:
            pose = plant.EvalBodyPoseInWorld(context, block)
            rotation = pose.rotation().matrix()
        if i % each == 0:
            rows.append(engine.seen(pose.translation(), rotation, b, scene["laser_m"]))
        if grip or held or not i:
            spin = plant.EvalBodySpatialVelocityInWorld(context, block).rotational()
            moment = engine.couple(rotation, spin, angle, grip, scene["crooked"])
            push.F_Bq_W = SpatialForce(moment, np.zeros(3))
            port.FixValue(context, [push])
            held = bool(grip)
        simulator.AdvanceTo((i + 1) * step_s)
    return rows


engine.answer(main(engine.scene()))
