"""Does it fall? The identified law under ground motions, and the probability of overturning.

Rocking under shaking is chaotic: one trajectory says nothing, an ensemble does. `ensemble.respond` runs it,
`fragility.fragility` sums it up.
"""

__all__ = ["draws", "ensemble", "fragility", "motions"]
