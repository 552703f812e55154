"""Signals of LCM logs."""

import pathlib
import tempfile
from csv import reader

import numpy as np

from ._documents import Document, document
from ._plots import plot_signal
from ._program import call


class Log(Document):
    """Signals of a run, a row a sample, float64, to the bit as they are in the log.

    time_s: n; floor_acceleration, frame_acceleration: n x channels, m/s^2; sigma, applied_force, command_force:
    n x legs, N (command_force NaN where the log has no answer); seq: n, which jumps where samples were lost.
    names: {signal: names of its columns}; info: what the log says of itself (sample_rate_hz, n_lost, ...).
    plot("sigma"): a picture."""

    plot = plot_signal


_groups = {"floor": "floor_acceleration", "sigma": "sigma", "applied": "applied_force", "frame": "frame_acceleration",
           "command": "command_force", "excitation": "excitation"}


def read_log(path, run_id=None, from_s=None, to_s=None, channels=None):
    """The signals of an LCM log as a Log. channels: a list of "floor", "sigma", "applied", "frame", "command",
    "excitation" (what was added to the commands to measure the loop, N; only where it is named), or single ones
    as in "frame:lens_x". Raises InputError."""
    with tempfile.TemporaryDirectory() as folder:
        csv = pathlib.Path(folder) / "log.csv"
        options = {"csv": csv, "run_id": run_id, "from": from_s, "to": to_s, "channels": ",".join(channels) if channels else None}
        info = call("export", path, options=options)["files"][0]
        # A row too few would read as one dimension.
        table = np.loadtxt(csv, delimiter=",", skiprows=1, ndmin=2, encoding="utf-8")
        with open(csv, newline="", encoding="utf-8") as file:
            columns = [name.rsplit(" [", 1)[0] for name in next(reader(file))]
    log, names = Log(), {}
    log["seq"] = table[:, columns.index("seq")].astype(np.int64)
    log["time_s"] = table[:, columns.index("time_s")]
    for group, name in _groups.items():
        own = [i for i, column in enumerate(columns) if column.startswith(group + ":")]
        if own:
            log[name] = table[:, own]
            names[name] = [columns[i].split(":", 1)[1] for i in own]
    log["names"] = names
    log["info"] = document(info)
    return log
