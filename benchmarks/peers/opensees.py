"""OpenSees: the model that `freerock export --to opensees` writes."""

from driver import answer
from to_opensees import prepare

answer(prepare)
