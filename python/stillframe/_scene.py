"""Scenes and what the program says of them."""

import json
import os
import pathlib
import tempfile
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Type, Union

import numpy as np
import numpy.typing as npt

from ._documents import Block, Complexes, Document, Floats, Option, Path, document
from ._log import Log, read_log
from ._plots import plot_singular_values
from ._program import InputError, call


class Modes(Document):
    """natural_frequencies_hz, damping_ratios (1), eigenvalues (rad/s), mode_shapes (dofs x modes), dofs: names of rows."""

    natural_frequencies_hz: Floats
    damping_ratios: Floats
    eigenvalues: Complexes
    mode_shapes: Floats
    dofs: List[str]


class LinearModel(Document):
    """A linear model about an operating point: x' = A x + B u, y = C x + D u, x = (q, q').

    A, B, C, D: the arrays of state_space; second_order: M, C, D, K, N, G, B and the rest of docs/notation.md;
    states, inputs, outputs: names and units; x0, u0, y0: the operating point."""

    state_space: Document
    second_order: Document
    states: List[str]
    inputs: List[Document]
    outputs: List[Document]

    @property
    def A(self) -> Floats:
        """n x n, 1/s and by the units of states"""
        return np.asarray(self["state_space"]["A"])

    @property
    def B(self) -> Floats:
        """n x columns; an input that is a motion has three, see inputs"""
        return np.asarray(self["state_space"]["B"])

    @property
    def C(self) -> Floats:
        """outputs x n"""
        return np.asarray(self["state_space"]["C"])

    @property
    def D(self) -> Floats:
        """outputs x columns of B"""
        return np.asarray(self["state_space"]["D"])

    def to_scipy(self) -> Any:
        """A scipy.signal.StateSpace of A, B, C, D."""
        from scipy import signal

        return signal.StateSpace(self.A, self.B, self.C, self.D)

    def to_control(self) -> Any:
        """A control.ss of A, B, C, D, with names; needs python-control."""
        import control

        columns = [f"{u.name}: {c.of}" if len(u.columns) > 1 else u.name for u in self["inputs"] for c in u.columns]
        names = {"states": self["states"], "inputs": columns, "outputs": [y.name for y in self["outputs"]]}
        return control.ss(self.A, self.B, self.C, self.D, **names)


class Design(Document):
    """One design: K_P, K_I (legs x legs, 1 and 1/s), closed_loop_poles (rad/s), spectral_radius, singular values over
    frequencies_hz, margins, recommended, warnings. The systems behind it: loops()."""

    legs: List[str]
    K_P: Optional[Floats]
    K_I: Optional[Floats]
    closed_loop_poles: Optional[Complexes]
    spectral_radius: float
    frequencies_hz: Floats
    margins: Optional[Document]
    warnings: List[str]
    _made_by: Tuple["Scene", Dict[str, Any]]

    def loops(self) -> Dict[str, Document]:
        """The linear systems of the loop, as {name: {A, B, C, D, Ts, input_names, ...}}: plant, open, closed, law and the
        others of docs/exports.md. Ts in s, 0 of what is continuous. Needs scipy."""
        from scipy import io

        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "loop.mat"
            scene, options = self._made_by
            scene._call("design", dict(options, mat=path), answers=(0, 3))
            found = io.loadmat(path, simplify_cells=True)
        return {name: Document(value) for name, value in found.items() if isinstance(value, dict) and "A" in value}


class SingularValues(Document):
    """singular_values (frequencies x min(outputs, inputs), largest first) over frequencies_hz, with a controller
    closed_singular_values and continuous_singular_values too. plot(): a picture."""

    frequencies_hz: Floats
    singular_values: Floats

    plot = plot_singular_values


class Run(Document):
    """A finished run: folder (its run directory), verdict, and the logs that were recorded, read on demand: passive,
    active, None where there is none."""

    folder: pathlib.Path
    verdict: Document

    def _log(self, loop: str) -> Optional[Log]:
        path = self["folder"] / f"{loop}.lcm"
        return read_log(path) if path.exists() else None

    @property
    def passive(self) -> Optional[Log]:
        """Log of the run with zero force, n x channels; None where there is none"""
        return self._log("passive")

    @property
    def active(self) -> Optional[Log]:
        """Log of the run in closed loop, n x channels; None where there is none"""
        return self._log("active")


def read_run(folder: Path) -> Run:
    """The Run in a run directory; its logs are read on demand, n x channels."""
    folder = pathlib.Path(folder)
    try:
        verdict = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{folder} is no finished run: {error}", 2) from None
    return Run(folder=folder, verdict=document(verdict, Document))


def identify(log: Path, **options: Option) -> Document:
    """Frequency responses of a log over frequency (Hz), with coherence and bands: `stillframe identify`, whose options are
    run_id, plant, segment (s), level and tolerance_db."""
    return document(call("identify", log, options=options, answers=(0, 4)), Document)


def _block(value: Block, folder: Path, name: str) -> Optional[pathlib.Path]:
    """The path of a block (controller, floor, uncertainty) that is a path already, or a dict."""
    if not isinstance(value, Mapping):
        return None if value is None else pathlib.Path(value).resolve()
    path = pathlib.Path(folder) / name
    path.write_text(json.dumps(dict(value)), encoding="utf-8")
    return path


class Scene:
    """A scene of docs/scene.md: the path of a YAML file, YAML text (with a line break in it), or a dict of the same keys.

    Nothing is checked before something is asked of it; then InputError names the file, line and key. Blocks
    (controller=, floor=, uncertainty=) are paths or dicts. folder: where a scene that is text or a dict finds the
    files that it names, the current one unless told."""

    def __init__(self, source: Union[Path, Dict[str, Any]], folder: Path = ".") -> None:
        self._text: Optional[str]
        self._path: Optional[pathlib.Path]
        if isinstance(source, dict):
            self._text, self._path = json.dumps(source, indent=1), None
        elif isinstance(source, str) and "\n" in source:
            self._text, self._path = source, None
        else:
            self._text, self._path = None, pathlib.Path(source).resolve()
        self._folder = self._path.parent if self._path else pathlib.Path(folder).resolve()

    @property
    def text(self) -> str:
        """The scene as text."""
        return self._path.read_text(encoding="utf-8") if self._path else str(self._text)

    def __repr__(self) -> str:
        return f"Scene({str(self._path)!r})" if self._path else f"Scene(<{len(self.text.splitlines())} lines>)"

    def _call(self, verb: str, options: Mapping[str, Any], answers: Tuple[int, ...] = (0,)) -> Any:
        with tempfile.TemporaryDirectory() as folder:
            options = dict(options)
            for name in ("controller", "floor", "uncertainty"):
                if name in options:
                    options[name] = _block(options[name], folder, name + ".yaml")
            other = options.get("design_scene")
            if isinstance(other, Scene):
                with other._file() as path:
                    return self._on_file(verb, dict(options, design_scene=path), answers)
            return self._on_file(verb, options, answers)

    def _on_file(self, verb: str, options: Mapping[str, Any], answers: Tuple[int, ...]) -> Any:
        with self._file() as path:
            # Messages call what was never a file by a name that says so.
            return call(verb, path, options=options, answers=answers, rename=None if self._path else (str(path), "<scene>"))

    def _file(self) -> "_SceneFile":
        return _SceneFile(self)

    def modes(self, lowest: Optional[int] = None) -> Modes:
        """Natural frequencies (Hz), damping ratios, eigenvalues (complex, rad/s) and mode_shapes (dofs x modes).

        lowest: only so many; of large scenes with `dofs: auto` in a fraction of the time."""
        return document(self._call("modes", {"lowest": lowest}), Modes)

    def equilibrium(self) -> Document:
        """Displacements (m, rad), deformations, stress resultants (N, N m) and reactions about which the scene rests."""
        return document(self._call("equilibrium", {}), Document)

    def buckling(self, count: Optional[int] = None) -> Document:
        """load_multipliers (1) of the loads at which the scene buckles, the smallest first, and their shapes (dofs x count)."""
        return document(self._call("buckling", {"count": count}), Document)

    def linearise(self, certify: bool = False) -> LinearModel:
        """A LinearModel (A: n x n) from the scene's inputs to its outputs. certify: hold every block against differences of the
        nonlinear equations; RunFailed if one is further off than 1e-9."""
        return document(self._call("linearise", {"certify": certify}), LinearModel)

    def sigma(self, from_hz: Optional[float] = None, to_hz: Optional[float] = None, points: Optional[int] = None,
              controller: Block = None) -> SingularValues:
        """SingularValues of the scene, or of open and closed loop where it has a controller, at `points` frequencies from from_hz
        to to_hz (Hz)."""
        options = {"from": from_hz, "to": to_hz, "points": points, "controller": controller}
        return document(self._call("sigma", options), SingularValues)

    def design(self, controller: Block = None, design_scene: Union["Scene", Path, None] = None) -> Design:
        """A Design (gains: legs x legs) of the scene's controller block, or of another one. design_scene: a Scene or path whose gains are
        taken. An unstable loop is a Design too, whose spectral_radius is not below 1."""
        options = {"controller": controller, "design_scene": design_scene}
        found = document(self._call("design", options, answers=(0, 3)), Design)
        object.__setattr__(found, "_made_by", (self, options))
        return found

    def feedback(self, **options: Option) -> Document:
        """PI, H2 and minimax feedback at equal margin: `stillframe feedback` (disk: 1; to_hz: Hz; controller)."""
        return document(self._call("feedback", options), Document)

    def budget(self, **options: Option) -> Document:
        """What each source adds to the frame (m/s^2): `stillframe budget` (controller, floor, duration in s, log, within, signal)."""
        return document(self._call("budget", options, answers=(0, 4)), Document)

    def robustness(self, **options: Option) -> Document:
        """Samples and worst case of frames that differ from the scene, over frequencies_hz (Hz): `stillframe robustness` (samples,
        seed, jobs, uncertainty, controller, no_search)."""
        return document(self._call("robustness", options), Document)

    def sweep(self, set: Mapping[str, Union[str, npt.ArrayLike]], at: Sequence[float] = (), controller: Block = None,
              jobs: int = 0) -> Document:
        """Designs over ranges of keys, in all combinations. set: {path: values}, as in {"controller.target_hz": [3, 5, 8]};
        a value may be the program's own text too ("2:20:10"). at: Hz. The result has rows, and for each path and figure
        an array of the same name in `columns` (NaN where a design has none, or where a value is no number)."""
        keys = [f"{path}={_values(values)}" for path, values in set.items()]
        options = {"set": keys, "at": ",".join(map(repr, map(float, at))) or None, "controller": controller, "jobs": jobs}
        found = document(self._call("sweep", options, answers=(0, 4)), Document)
        figures = ("spectral_radius", "disk_margin", "disk_margin_hz", "price_of_sampling_db", "peak", "peak_hz")
        columns = {path: np.array([_number(row["set"][path]) for row in found.rows]) for path in set}
        columns.update({name: np.array([_number(row[name]) for row in found.rows]) for name in figures})
        for i, hz in enumerate(at):
            columns[f"transmission_{hz:g}_hz"] = np.array([_number(row.transmission[i].singular_value) for row in found.rows])
        found["columns"] = Document(columns)
        return found

    def run(self, out: Path, mode: str = "single_process", loop: str = "both", duration: Optional[float] = None,
            controller: Block = None, floor: Block = None, design_scene: Union["Scene", Path, None] = None) -> Run:
        """Simulates the scene, passive and active, for `duration` s, into a new run directory `out`, as a Run. mode: "single_process", or
        "lock_step" over LCM with processes of their own (the same bits). The verdict's outcome may be "failed":
        that is a result. RunFailed where there is none."""
        options = {"mode": mode, "loop": loop, "duration": None if duration is None else float(duration),
                   "controller": controller, "floor": floor, "design_scene": design_scene, "out": pathlib.Path(out).resolve()}
        self._call("run", options, answers=(0, 4))
        return read_run(out)


def _values(values: Any) -> str:
    if isinstance(values, str):
        return values
    items = values if np.ndim(values) else [values]
    return ",".join(repr(float(v)) if isinstance(v, (float, np.floating)) else str(v) for v in items)


def _number(value: Any) -> float:
    try:
        return float("nan") if value is None else float(value)
    except ValueError:
        return float("nan")


class _SceneFile:
    """The path of a scene for as long as it is used: text is written beside the files that it names, or else, where
    that folder takes no file, they are not found and the program says so."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._made: Optional[pathlib.Path] = None

    def __enter__(self) -> pathlib.Path:
        if self._scene._path:
            return self._scene._path
        folder = self._scene._folder if os.access(self._scene._folder, os.W_OK) else None
        handle, name = tempfile.mkstemp(prefix=".scene-", suffix=".yaml", dir=folder)
        self._made = pathlib.Path(name)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(self._scene.text)
        return self._made

    def __exit__(self, *_: object) -> None:
        if self._made:
            self._made.unlink(missing_ok=True)
