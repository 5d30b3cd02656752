"""Drake: a block on small spheres with Hunt and Crossley's point contact, f = k x (1 + (λ/k) ẋ) ≥ 0.

That is the tensionless rule. Joints guide the base centre, so that the spheres' friction has no part in it.
"""

import numpy as np
from driver import answer, places, steps
from pydrake.geometry import HalfSpace, ProximityProperties, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import PrismaticJoint, RevoluteJoint, RotationalInertia, SpatialInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder

RADIUS = 0.01  # of the spheres; the ground lies as much lower


def prepare(scene, setting):
    """Setting: points, and rtol of Runge and Kutta's third order or step_s of Drake's discrete solver."""
    b, h, m, theta = (scene[name] for name in ("b", "h", "m", "theta0"))
    us, width = places(scene, setting["points"])
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, setting.get("step_s", 0.0))
    about = m * (b * b + h * h) / 3
    inertia = SpatialInertia.MakeFromCentralInertia(
        m, np.array([0.0, 0.0, h]), RotationalInertia(about, about, 1.5 * about)
    )
    massless = SpatialInertia.MakeFromCentralInertia(1e-9, np.zeros(3), RotationalInertia(*3 * (1e-12,)))
    lift, block = plant.AddRigidBody("lift", massless), plant.AddRigidBody("block", inertia)
    up = plant.AddJoint(PrismaticJoint("up", plant.world_frame(), lift.body_frame(), [0, 0, 1]))
    turn = plant.AddJoint(RevoluteJoint("turn", lift.body_frame(), block.body_frame(), [0, 1, 0]))

    def material():
        # two in series
        properties = ProximityProperties()
        properties.AddProperty("material", "point_contact_stiffness", 2 * scene["k"] * width)
        properties.AddProperty("material", "hunt_crossley_dissipation", scene["lambda"] / scene["k"])
        properties.AddProperty("material", "coulomb_friction", CoulombFriction(0.0, 0.0))
        return properties

    for i, u in enumerate(us):
        plant.RegisterCollisionGeometry(
            block, RigidTransform([u, 0.0, 0.0]), Sphere(RADIUS), f"{i}", material()
        )
    ground = RigidTransform([0.0, 0.0, -RADIUS])
    plant.RegisterCollisionGeometry(plant.world_body(), ground, HalfSpace(), "ground", material())
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -scene["g"]])
    plant.Finalize()
    simulator = Simulator(builder.Build())
    if "rtol" in setting:
        ResetIntegratorFromFlags(simulator, "runge_kutta3", 1e-3)
        simulator.get_mutable_integrator().set_target_accuracy(setting["rtol"])
        simulator.get_mutable_integrator().set_maximum_step_size(scene["every_s"])
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    up.set_translation(context, -scene["z0"])
    turn.set_angle(context, theta)
    simulator.Initialize()

    def run():
        found = [theta]
        for i in range(1, steps(scene) + 1):
            simulator.AdvanceTo(i * scene["every_s"])
            found.append(turn.get_angle(context))
        return found

    return run


answer(prepare)
