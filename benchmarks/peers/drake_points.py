"""Drake: the model that `freerock export --to drake` writes; a module named drake would hide its own."""

from driver import answer
from to_drake import prepare

answer(prepare)
