"""Drake: the model that `freerock export --to drake` writes."""

from driver import answer
from to_drake import prepare

answer(prepare)
