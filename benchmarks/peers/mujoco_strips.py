"""MuJoCo: the model that `freerock export --to mujoco` writes."""

from driver import answer
from to_mujoco import prepare

answer(prepare)
