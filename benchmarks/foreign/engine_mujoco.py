"""MuJoCo: a box in space on a plane, with friction and soft contacts at its corners."""

import engine
import mujoco
import numpy as np

STEP_S = 2e-4


def main(scene):
    """The motion of a scene."""
    b, h, d = scene["width_m"] / 2, scene["height_m"] / 2, scene["depth_m"] / 2
    seconds, ratio = scene["contact"]
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco>
        <option timestep="{STEP_S}" gravity="0 0 -9.81" cone="elliptic" integrator="implicitfast"/>
        <default><geom solref="{seconds} {ratio}" friction="{scene["mu"]} 0.005 0.0001" condim="4"/></default>
        <worldbody><geom type="plane" size="1 1 1"/><body name="block" pos="0 0 {h}"><freejoint/>
        <geom type="box" size="{b} {d} {h}" mass="{scene["mass_kg"]}"/></body></worldbody></mujoco>"""
    )
    data, rows = mujoco.MjData(model), []
    body, each = model.body("block").id, round(1e-3 / STEP_S)
    for i in range(round(scene["until_s"] / STEP_S)):
        rotation = data.xmat[body].reshape(3, 3)
        if i % each == 0:
            mujoco.mj_forward(model, data)
            rows.append(engine.seen(data.xpos[body], rotation, b, scene["laser_m"]))
        angle, grip = engine.wanted(i * STEP_S, scene["runs"])
        data.xfrc_applied[body, 3:] = 0.0
        if grip:
            # MuJoCo's spin of a free joint is that in the body's axes
            spin = rotation @ np.array(data.qvel[3:])
            data.xfrc_applied[body, 3:] = engine.couple(rotation, spin, angle, grip, scene["crooked"])
        mujoco.mj_step(model, data)
    return rows


engine.answer(main(engine.scene()))
