"""Pictures by matplotlib, which is asked for only here."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ._documents import Document, Floats
from ._program import InputError, meant

# matplotlib.axes.Axes, which only those have who have matplotlib.
Axes = Any


def axes_of(axes: Axes) -> Axes:
    """The axes that were given, or new ones. Raises ImportError without matplotlib."""
    if axes is not None:
        return axes
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained")[1]


def _decibels(values: npt.ArrayLike) -> Floats:
    array = np.asarray(values, dtype=float)
    return np.asarray(20 * np.log10(np.where(array > 0, array, np.nan)))


def plot_singular_values(document: Document, axes: Axes = None) -> Axes:
    """Singular values (dB) over frequency (Hz): open and, with a controller, closed. axes: matplotlib's, which come back; new
    ones unless told."""
    axes = axes_of(axes)
    for key, label, colour in (("singular_values", "open", "#d35400"), ("closed_singular_values", "closed", "#0072b2")):
        if document.get(key) is None:
            continue
        lines = axes.semilogx(document["frequencies_hz"], _decibels(document[key]), color=colour, linewidth=1.2)
        lines[0].set_label(label)
    axes.set_xlabel("frequency (Hz)")
    axes.set_ylabel("singular values (dB)")
    axes.grid(True, color="0.9")
    axes.legend(frameon=False)
    return axes


def plot_signal(log: Document, signal: str, axes: Axes = None) -> Axes:
    """A signal of a log (N, or m/s^2) over time (s), a line a column. axes: matplotlib's, which come back; new ones unless told."""
    if signal not in log["names"]:
        raise InputError(f"plot: no signal {signal!r}{meant(signal, log['names'])}", 2)
    axes = axes_of(axes)
    units = {"floor_acceleration": "m/s²", "frame_acceleration": "m/s²"}
    for name, values in zip(log["names"][signal], log[signal].T):
        axes.plot(log["time_s"], values, label=name, linewidth=0.8)
    axes.set_xlabel("time (s)")
    axes.set_ylabel(f"{signal.replace('_', ' ')} ({units.get(signal, 'N')})")
    axes.grid(True, color="0.9")
    axes.legend(frameon=False, ncols=3, fontsize="small")
    return axes
