"""Signals of LCM logs."""

import pathlib
import tempfile
from csv import reader
from typing import Dict, List, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from ._documents import Document, Floats, Path, document
from ._plots import plot_signal
from ._program import call


class Log(Document):
    """Signals of a run, a row a sample, float64, to the bit as they are in the log.

    time_s: n; floor_acceleration, frame_acceleration: n x channels, m/s^2; sigma, applied_force, command_force:
    n x legs, N (command_force NaN where the log has no answer); seq: n, which jumps where samples were lost.
    names: {signal: names of its columns}; info: what the log says of itself (sample_rate_hz, n_lost, ...).
    plot("sigma"): a picture."""

    seq: npt.NDArray[np.int64]
    time_s: Floats
    names: Dict[str, List[str]]
    info: Document

    plot = plot_signal


_groups = {"floor": "floor_acceleration", "sigma": "sigma", "applied": "applied_force", "frame": "frame_acceleration",
           "command": "command_force", "excitation": "excitation"}


def read_log(path: Path, run_id: Optional[int] = None, from_s: Optional[float] = None, to_s: Optional[float] = None,
             channels: Union[str, Sequence[str], None] = None) -> Log:
    """The signals of an LCM log as a Log, from from_s to to_s (s). channels: one or a list of "floor", "sigma", "applied", "frame",
    "command", "excitation" (what was added to the commands to measure the loop, N; only where it is named), or single ones
    as in "frame:lens_x". Raises InputError."""
    with tempfile.TemporaryDirectory() as folder:
        csv = pathlib.Path(folder) / "log.csv"
        channels = [channels] if isinstance(channels, str) else channels
        options = {"csv": csv, "run_id": run_id, "from": from_s, "to": to_s, "channels": ",".join(channels) if channels else None}
        info = call("export", path, options=options)["files"][0]
        # Not of the log, but of the file between.
        info = {key: value for key, value in info.items() if key not in ("file", "format", "bytes")}
        # A row too few would read as one dimension.
        table = np.loadtxt(csv, delimiter=",", skiprows=1, ndmin=2, encoding="utf-8")
        with open(csv, newline="", encoding="utf-8") as file:
            columns = [name.rsplit(" [", 1)[0] for name in next(reader(file))]
    log = Log(seq=table[:, columns.index("seq")].astype(np.int64), time_s=table[:, columns.index("time_s")])
    names: Dict[str, List[str]] = {}
    for group, name in _groups.items():
        own = [i for i, column in enumerate(columns) if column.startswith(group + ":")]
        if own:
            setattr(log, name, table[:, own])
            names[name] = [columns[i].split(":", 1)[1] for i in own]
    log.names = names
    log.info = document(info, Document)
    return log
