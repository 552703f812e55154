"""Scenes and what the program says of them."""

import contextlib
import json
import os
import pathlib
import tempfile
from typing import Any, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

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
        return self._matrix("A")

    @property
    def B(self) -> Floats:
        """n x columns; an input that is a motion has three, see inputs"""
        return self._matrix("B")

    @property
    def C(self) -> Floats:
        """outputs x n"""
        return self._matrix("C")

    @property
    def D(self) -> Floats:
        """outputs x columns of B"""
        return self._matrix("D")

    def _matrix(self, name: str) -> Floats:
        # A matrix without rows has no columns in JSON.
        rows = len(self["outputs"] if name in "CD" else self["states"])
        columns = sum(len(u.columns) for u in self["inputs"]) if name in "BD" else len(self["states"])
        return np.reshape(self["state_space"][name], (rows, columns))

    def to_scipy(self, integrate: bool = False) -> Any:
        """A scipy.signal.StateSpace of A, B, C, D. Its inputs are the columns of B: an input that is a motion is three of them,
        acceleration, velocity and position in this order (inputs[i].columns), of which one follows from another: the
        response to the acceleration is that to the first column, that to the second over s and that to the third over s^2,
        added. integrate=True: that system, exactly, an input a name; a motion's is its acceleration, whatever its kind, and
        its integrals are the last states, velocities before positions. InputError without inputs or outputs. Needs scipy."""
        from scipy import signal

        for key in ("inputs", "outputs"):
            if not self[key]:
                raise InputError(f"to_scipy: the scene has no {key}, which a StateSpace needs", 2)
        A, B, C, D = self.A, self.B, self.C, self.D
        if not integrate:
            return signal.StateSpace(A, B, C, D)
        columns = [{c.of: c.column for c in u.columns} for u in self["inputs"]]
        first = [of.get("direct", of.get("acceleration")) for of in columns]
        moved = [i for i, of in enumerate(columns) if "acceleration" in of]
        velocity, position = ([columns[i][of] for i in moved] for of in ("velocity", "position"))
        n, m = len(A), len(moved)
        into = np.zeros((2 * m, len(first)))
        into[range(m), moved] = 1
        integrators = np.hstack([np.zeros((2 * m, n)), np.eye(2 * m, k=-m)])
        return signal.StateSpace(
            np.vstack([np.hstack([A, B[:, velocity], B[:, position]]), integrators]), np.vstack([B[:, first], into]),
            np.hstack([C, D[:, velocity], D[:, position]]), D[:, first])

    def to_control(self) -> Any:
        """A control.ss of A, B, C, D, with names; of motions as to_scipy has them. Needs python-control."""
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
    # What loops() asks again; no key.
    __slots__ = ("_made_by",)
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
    try:
        folder = pathlib.Path(folder)
        verdict = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    except (OSError, TypeError, ValueError) as error:
        raise InputError(f"{folder} is no finished run: {error}", 2) from None
    return Run(folder=folder, verdict=document(verdict, Document))


def identify(log: Path, **options: Option) -> Document:
    """Frequency responses of a log (its path) over frequency (Hz), with coherence and bands: `stillframe identify`, whose
    options are run_id, plant, segment (s), level and tolerance_db; types and defaults: stillframe.help("identify"). Warns,
    with a UserWarning, if nothing is identified, or with tolerance_db nothing compared or something beyond it."""
    return document(call("identify", log, options=options, answers=(0, 4), failed=_not_identified), Document)


def _not_identified(found: Mapping[str, Any]) -> Iterable[str]:
    for name in ("matrix", "axes"):
        response = found.get(name) or {"missing": "", "comparison": None}
        comparison = response["comparison"] or {"agrees": True}
        if response["missing"]:
            yield f"{name} is not identified: {response['missing']}"
        elif comparison["agrees"] is None:
            yield f"{name}: nothing could be compared"
        elif not comparison["agrees"]:
            yield (f"{name}: measured {comparison['beyond_db']:.3g} dB outside the bands of what is predicted at "
                   f"{comparison['beyond_at_hz']:.4g} Hz, allowed is {comparison['tolerance_db']:g}")


def _not_met(found: Mapping[str, Any]) -> Iterable[str]:
    for run in found["runs"]:
        for name, axis in run["axes"].items():
            if not axis["met"]:
                yield (f"{run['log']}: {name}: measured {axis['measured_m_s2']:.4g} m/s^2, predicted "
                       f"{axis['predicted_m_s2']:.4g} with a scatter of {axis['scatter_m_s2']:.2g}")


def _plain(value: Any, name: str, path: str = "") -> Any:
    """What JSON can write of a value of a scene or a block; name: of it, path: the key, for messages."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item, name, f"{path}.{key}".lstrip(".")) for key, item in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(item, name, f"{path}[{i}]") for i, item in enumerate(value, 1)]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if value is None or isinstance(value, (str, bool, int, float)):
        return value
    found = f"found {value!r:.60} ({type(value).__name__})"
    raise InputError(f"<{name}>: {path}: {found}, allowed are numbers, texts, lists, arrays and dicts", 2)


class Scene:
    """A scene of docs/scene.md (stillframe.help("scene") prints it): the path of a YAML file, YAML text (with a line break in
    it), or a dict of the same keys, with arrays of numpy too.

    Nothing but what a dict is made of is checked before something is asked of it; then InputError names the file, line and
    key. Blocks (controller=, floor=, uncertainty=) and design_scene= are paths, texts or dicts, which messages call
    <controller> and so on. folder: where what is text or a dict finds the files that it names, the current one unless
    told. name: what messages call it then.

    A run belongs to a scene by scene_hash, the hash of its text: the same dict in another order of keys, or the same
    numbers written otherwise, is another scene to budget(log=) and the like."""

    def __init__(self, source: Union["Scene", Path, Mapping[str, Any]], folder: Path = ".", name: str = "scene") -> None:
        self._name = name
        self._text: Optional[str] = None
        self._path: Optional[pathlib.Path] = None
        self._folder: pathlib.Path
        if isinstance(source, Scene):
            self._text, self._path, folder = source._text, source._path, source._folder
        elif isinstance(source, Mapping):
            self._text = json.dumps(_plain(source, name), indent=1)
        elif isinstance(source, str) and "\n" in source:
            self._text = source
        elif isinstance(source, (str, os.PathLike)):
            self._path = pathlib.Path(source).resolve()
        else:
            raise InputError(f"<{name}>: found {type(source).__name__}, allowed is a path, YAML text, a dict or a Scene", 2)
        self._folder = self._path.parent if self._path else pathlib.Path(folder).resolve()

    @property
    def text(self) -> str:
        """The scene as text."""
        return self._path.read_text(encoding="utf-8") if self._path else str(self._text)

    def __repr__(self) -> str:
        return f"Scene({str(self._path)!r})" if self._path else f"Scene(<{len(self.text.splitlines())} lines>)"

    def _call(self, verb: str, options: Mapping[str, Any], **more: Any) -> Any:
        with contextlib.ExitStack() as files:
            names: Dict[str, str] = {}

            def path(source: Scene) -> pathlib.Path:
                made = files.enter_context(source._file())
                if not source._path:
                    names[str(made)] = f"<{source._name}>"
                return made

            options = dict(options)
            for name in ("controller", "floor", "uncertainty", "design_scene"):
                if options.get(name) is not None:
                    options[name] = path(Scene(options[name], self._folder, name))
            return call(verb, path(self), options=options, names=names, **more)

    @contextlib.contextmanager
    def _file(self) -> Iterator[pathlib.Path]:
        """The path for as long as it is used: text is written beside the files that it names, or else, where that folder
        takes no file, they are not found and the program says so."""
        if self._path:
            yield self._path
            return
        folder = self._folder if os.access(self._folder, os.W_OK) else None
        handle, name = tempfile.mkstemp(prefix=f".{self._name}-", suffix=".yaml", dir=folder)
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(self.text)
            yield pathlib.Path(name)
        finally:
            os.unlink(name)

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

    def design(self, controller: Block = None, design_scene: Union["Scene", Block] = None) -> Design:
        """A Design (gains: legs x legs) of the scene's controller block, or of another one. design_scene: a scene whose gains are taken.
        An unstable loop is a Design too, whose spectral_radius is not below 1."""
        options = {"controller": controller, "design_scene": design_scene}
        found = document(self._call("design", options, answers=(0, 3)), Design)
        found._made_by = (self, options)
        return found

    def feedback(self, **options: Option) -> Document:
        """PI, H2 and minimax feedback at equal margin: `stillframe feedback` (disk: 1; to_hz: Hz; controller; ...). Types and
        defaults of options: stillframe.help("feedback")."""
        return document(self._call("feedback", options), Document)

    def budget(self, **options: Option) -> Document:
        """What each source adds to the frame (m/s^2): `stillframe budget` (controller, floor, duration in s, log, within in %,
        signal; lists of log and signal). Types and defaults of options: stillframe.help("budget"). Warns, with a UserWarning, of
        what of a log is further off than `within`."""
        return document(self._call("budget", options, answers=(0, 4), failed=_not_met), Document)

    def robustness(self, **options: Option) -> Document:
        """Samples and worst case of frames that differ from the scene, over frequencies_hz (Hz): `stillframe robustness` (samples,
        seed, jobs, uncertainty, controller, no_search, ...). Types and defaults of options: stillframe.help("robustness")."""
        return document(self._call("robustness", options), Document)

    def sweep(self, set: Mapping[str, Union[str, npt.ArrayLike]], at: Union[float, Sequence[float]] = (), controller: Block = None,
              jobs: int = 0) -> Document:
        """Designs over ranges of keys, in all combinations. set: {path: values}, as in {"controller.target_hz": [3, 5, 8]};
        a value may be the program's own text too ("2:20:10"). at: Hz. The result has rows, and for each path and figure
        an array of the same name in `columns` (NaN where a design has none, or where a value is no number)."""
        frequencies = np.ravel(at).tolist()
        keys = [f"{path}={_values(values)}" for path, values in set.items()]
        options = {"set": keys, "at": ",".join(repr(float(hz)) for hz in frequencies) or None, "controller": controller, "jobs": jobs}
        found = document(self._call("sweep", options, answers=(0, 4)), Document)
        figures = ("spectral_radius", "disk_margin", "disk_margin_hz", "price_of_sampling_db", "peak", "peak_hz")
        columns = {path: np.array([_number(row["set"][path]) for row in found.rows]) for path in set}
        columns.update({name: np.array([_number(row[name]) for row in found.rows]) for name in figures})
        for i, hz in enumerate(frequencies):
            columns[f"transmission_{hz:g}_hz"] = np.array([_number(row.transmission[i].singular_value) for row in found.rows])
        return Document(vars(found), columns=Document(columns))

    def run(self, out: Path, mode: str = "single_process", loop: str = "both", duration: Optional[float] = None,
            controller: Block = None, floor: Block = None, design_scene: Union["Scene", Block] = None) -> Run:
        """Simulates the scene, passive and active, for `duration` s, into a new run directory `out`, as a Run. mode: "single_process", or
        "lock_step" over LCM with processes of their own (the same bits). The verdict's outcome may be "failed":
        that is a result. RunFailed where there is none."""
        options = {"mode": mode, "loop": loop, "duration": duration,
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

