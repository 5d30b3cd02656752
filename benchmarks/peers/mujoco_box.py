"""MuJoCo: a box on a plane as it comes, with friction and the contact's default or shortest time constant.

No coefficient of restitution can be given: the box loses what its soft contacts take.
"""

import math

import mujoco
from driver import answer, steps, substeps


def prepare(scene, setting):
    """Setting: step_s, and time_constant_s of the contact or none for the default of 0.02 s."""
    b, h, theta = scene["b"], scene["h"], scene["theta0"]
    stiff = f'solref="{setting["time_constant_s"]} 1"' if "time_constant_s" in setting else ""
    about = scene["m"] * (b * b + h * h) / 3
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco>
        <option timestep="{setting["step_s"]}" gravity="0 0 -{scene["g"]}" integrator="implicitfast"/>
        <default><geom {stiff} friction="1 0 0"/></default>
        <worldbody><geom type="plane" size="1 1 1"/>
          <body name="block">
            <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
            <joint type="hinge" axis="0 1 0"/>
            <geom type="box" size="{b} {h} {h}" mass="{scene["m"]}"/>
            <inertial pos="0 0 0" mass="{scene["m"]}" diaginertia="{about} {about} {about}"/>
          </body>
        </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    # turned about the corner (b, 0)
    across, up = -b * math.cos(theta) + h * math.sin(theta), b * math.sin(theta) + h * math.cos(theta)
    data.qpos[:] = b + across, up, theta

    def run():
        found = [theta]
        for _ in range(steps(scene)):
            for _ in range(substeps(scene, setting["step_s"])):
                mujoco.mj_step(model, data)
            found.append(data.qpos[2])
        return found

    return run


answer(prepare)
