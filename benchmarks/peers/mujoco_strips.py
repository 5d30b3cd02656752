"""MuJoCo: a block on small spheres, each a soft contact for a strip of a bed, f = k z + c ż ≥ 0.

That is the tensionless rule. MuJoCo's contact is a soft constraint with a reference acceleration -k′ z - c′ ż
and an impedance d. For d → 0 its force is d/(1 - d) of that over the weight A of the body, so k′ and c′ are
chosen for k and c; the remainder is of the order of d.
"""

import math

import mujoco
from driver import answer, places, steps, substeps

IMPEDANCE = 1e-4
RADIUS = 0.01  # of the spheres; the ground lies as much lower


def prepare(scene, setting):
    """Setting: strips, step_s."""
    b, h, m, theta = (scene[name] for name in ("b", "h", "m", "theta0"))
    us, width = places(scene, setting["strips"])
    spheres = "".join(f'<geom type="sphere" size="{RADIUS}" pos="{u:.17g} 0 0"/>' for u in us)
    about = m * (b * b + h * h) / 3
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco>
        <option timestep="{setting["step_s"]}" gravity="0 0 -{scene["g"]}" integrator="RK4"/>
        <default><geom condim="1" mass="0"/></default>
        <worldbody><geom type="plane" pos="0 0 -{RADIUS}" size="1 1 1"/>
          <body name="block">
            <joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>
            <inertial pos="0 0 {h}" mass="{m}" diaginertia="{about} {about} {about}"/>{spheres}
          </body>
        </worldbody></mujoco>"""
    )
    compliance = (1 - IMPEDANCE) / IMPEDANCE * model.body_invweight0[model.body("block").id, 0]
    model.geom_solimp[:] = [IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2]
    model.geom_solref[:] = [-scene[name] * width * compliance * IMPEDANCE for name in ("k", "c")]
    data = mujoco.MjData(model)
    data.qpos[:] = -scene["z0"], theta

    def run():
        found = [theta]
        for _ in range(steps(scene)):
            for _ in range(substeps(scene, setting["step_s"])):
                mujoco.mj_step(model, data)
            if not math.isfinite(data.qpos[1]):
                raise ArithmeticError("not finite")
            found.append(data.qpos[1])
        return found

    return run


answer(prepare)
