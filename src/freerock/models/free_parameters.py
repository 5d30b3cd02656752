"""The numbers that a fit can find: parameters of the laws, and what it frees besides; one row each.

Nothing is imported here that is slow to load: the configuration reads the rows, too.
"""

from dataclasses import dataclass
from math import inf
from typing import Literal


@dataclass(frozen=True)
class Parameter:
    """A number that a fit can find.

    Parameters
    ----------
    unit : str
        Its unit, as in netCDF and tables; "1" for a pure number.
    symbol : str
        As printed.
    fitted_as : str
        The number that the optimiser moves: "value", "logarithm", "ratio" (the logarithm of the ratio to the
        stiffness k) or "share" (of the nominal value).
    step : float
        Step of the difference quotients, in that number.
    bounds : (float, float)
        Bounds of a fit, of the value, of the ratio to k or of the share: the frame inside the stability atlas
        (docs/validation.md) in which every simulation ends. The run narrows those of r, θ₀ and t₀.
    grid : (float, float, int)
        Lowest and highest value (ratio to k, share; 1 - r) of the starting grid of a foundation's law, of r
        and the width that of a rigid block, and the number of values, in geometric order.
    trace : float
        A small value (ratio to k), from which a fit starts that frees it beside all else.
    ratio_unit : str
        Unit of the ratio to k.
    """

    unit: str
    symbol: str
    fitted_as: Literal["value", "logarithm", "ratio", "share"]
    step: float
    bounds: tuple[float, float] = (-inf, inf)
    grid: tuple[float, float, int] = (0.0, 0.0, 0)
    trace: float = 0.0
    ratio_unit: str = ""


LOGARITHMS = ("logarithm", "ratio")  # ways to fit a number that is positive

PARAMETERS = {
    "r": Parameter("1", "r", "value", -1e-5, bounds=(1e-3, 1.0), grid=(1e-4, 0.95, 170)),
    "k": Parameter("N m-2", "k", "logarithm", 1e-5, bounds=(1e4, 1e11), grid=(3e5, 1e9, 16)),
    "c": Parameter(
        "N s m-2",
        "c",
        "ratio",
        1e-5,
        bounds=(1e-5, 1.0),
        grid=(1.25e-4, 0.08, 9),
        trace=1e-4,
        ratio_unit="s",
    ),
    "lambda": Parameter(
        "N s m-3",
        "λ",
        "ratio",
        1e-5,
        bounds=(1e-2, 1e4),
        grid=(2, 200, 8),
        trace=1.0,
        ratio_unit="s/m",
    ),
    "width": Parameter(
        "m", "2b", "share", 1e-6, bounds=(0.5, 1.05), grid=(0.55, 1.04, 17)
    ),  # of the corners a block rocks about
    "tilt": Parameter("rad", "τ", "value", 1e-6, bounds=(-0.03, 0.03)),  # of the base, to the right
    "edge_radius": Parameter("m", "ρ", "value", 1e-6, bounds=(0.0, 5e-3), trace=5e-4),  # of the base
    "theta0": Parameter("rad", "θ₀", "value", 1e-6),
    "t0": Parameter("s", "t₀", "value", 1e-5),
}

PER_RUN = ("theta0", "t0")
OF_RECORD = ("width", "tilt", "edge_radius")  # what the runs of a record share besides the law
COMMON_NUISANCES = (*OF_RECORD, *PER_RUN)

SYMBOLS = {name: parameter.symbol for name, parameter in PARAMETERS.items()}
