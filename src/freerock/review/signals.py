"""What is drawn of a record over time: samples in single precision, thinned so that no extreme is lost."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from freerock.arrays import Flags, Floats
from freerock.figures.looks import extremes
from freerock.rotation.flags import BY_HAND, FLAGS
from freerock.units import BASE

Json = dict[str, Any]
Channel = tuple[str, str, NDArray[np.float32]]
BINS = 900  # of a curve, with two samples drawn in each: about as many as it has columns on the screen
FLAGGED_DRAWN = 200  # stretches of invalid samples drawn; those that are near each other become one


@dataclass(frozen=True)
class Signals:
    """A record over even time.

    Parameters
    ----------
    start_s, step_s : float
        First instant and sampling interval [s].
    n : int
        Samples.
    channels : list of (str, str, ndarray of float32)
        Label, unit and values, shape (n,), of what was recorded.
    theta : ndarray, shape (n,), or None
        Rotation [rad] in single precision; None where the channels could not become one.
    flags : ndarray of uint8, shape (n,), or None
        As `rotation.flags.FLAGS` has them.
    """

    start_s: float
    step_s: float
    n: int
    channels: list[Channel]
    theta: NDArray[np.float32] | None = None
    flags: Flags | None = None

    @property
    def span_s(self) -> tuple[float, float]:
        """First and last instant [s]."""
        return self.start_s, self.start_s + (self.n - 1) * self.step_s

    def window(self, from_s: float, to_s: float) -> Json:
        """The signals between two instants.

        Parameters
        ----------
        from_s, to_s : float
            Instants [s].

        Returns
        -------
        dict
            signals: label, unit, time, value of each channel; theta: time, value [degree]; flags: start, end
            [s] and what is wrong, of each stretch of invalid samples.
        """
        counted = np.ceil((np.array([from_s, to_s]) - self.start_s) / self.step_s)
        first, last = np.clip(np.nan_to_num(counted), 0, self.n).astype(int).tolist()
        shown = slice(max(0, first - 1), last + 1)
        time_s: Floats = self.start_s + self.step_s * np.arange(*shown.indices(self.n), dtype=float)
        found: Json = {"signals": [], "theta": None, "flags": []}
        for label, unit, values in self.channels:
            found["signals"].append({"label": label, "unit": unit} | thinned(time_s, values[shown]))
        if self.theta is not None and self.flags is not None:
            found["theta"] = thinned(time_s, np.degrees(self.theta[shown]))
            found["flags"] = _flagged(time_s, self.flags[shown])
        return found


def signals_of(record: xr.Dataset) -> Signals:
    """The signals of a record over time [s]: channels, and where it could be processed theta [rad], flags."""
    time_s = record["time"].values
    step_s = float(time_s[-1] - time_s[0]) / (len(time_s) - 1) if len(time_s) > 1 else 1.0
    found = (_single(record["theta"]), record["flags"].values) if "theta" in record else ()
    return Signals(float(time_s[0]), step_s, len(time_s), [*_channels(record)], *found)


def _channels(record: xr.Dataset) -> Iterator[Channel]:
    for name, variable in record.data_vars.items():
        kind, _, second = str(name).partition("_")
        if variable.dims == ("time",) and (kind in BASE or "theta" not in record):
            label = f"{kind} of laser {second}" if second.isdigit() else kind
            unit = BASE.get(kind) or str(variable.attrs.get("units", ""))
            yield label, unit, _single(variable)


def _single(variable: xr.DataArray) -> NDArray[np.float32]:
    return variable.values.astype(np.float32)


def thinned(time_s: Floats, values: Floats | NDArray[np.float32]) -> Json:
    """Time [s] and value of the lowest and highest sample in each of `BINS` bins."""
    kept = extremes(values, BINS)
    return {
        "t": [round(float(t), 5) for t in time_s[kept]],
        "v": [screen_digits(float(v)) for v in values[kept]],
    }


def screen_digits(value: float) -> float | None:
    """A number with as many digits as a screen shows, None where there is none."""
    return float(f"{value:.7g}") if math.isfinite(value) else None


def _flagged(time_s: Floats, flags: Flags) -> list[list[Any]]:
    """Start, end [s] and what is wrong, of each stretch of invalid samples."""
    bad = np.flatnonzero(flags)
    if not bad.size:
        return []
    near = max(1, len(time_s) // FLAGGED_DRAWN)
    parts = np.split(bad, np.flatnonzero(np.diff(bad) > near) + 1)
    found = []
    for part in parts:
        seen = int(np.bitwise_or.reduce(flags[part]))
        told = ", ".join(name.replace("_", " ") for name, bit in (FLAGS | BY_HAND).items() if seen & bit)
        found.append([float(time_s[part[0]]), float(time_s[part[-1]]), told])
    return found
