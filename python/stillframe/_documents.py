"""Documents of the program as Python objects: keys are attributes, lists of numbers are numpy arrays."""

import html
import os
from typing import TYPE_CHECKING, Any, Iterator, KeysView, Mapping, Type, TypeVar, Union

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]

# A file, or a block of its keys (a controller, a floor); None: the scene's own.
Path = Union[str, "os.PathLike[str]"]
Block = Union[Path, Mapping[str, Any], None]
# What an option of the program may be.
Option = Union[Block, bool, float]

# What JSON does not tell and docs/json does (a test holds these against it): pairs [re, im], whole numbers, and keys
# whose lists are of texts or documents, so that an empty one is no array.
_complex = {"eigenvalues", "closed_loop_poles", "T", "T_sampled", "T_continuous"}
_whole = {"counts", "done"}
_lists = set("""axes bounds certificates checks columns curve deviations dof_units dofs effort elements files floor
    highest_singular_values_db inputs largest_singular_values_db least_damping_ratio legs methods nodal_displacements noise
    notes outputs parameters peak peaks ranges reactions responses resting_channels resting_forces rows runs shocks sources
    spectral_radius state_units states timing transmissibility transmission warnings""".split())


def _numbers(value: Any) -> bool:
    """Whether a list holds numbers and nulls alone, at any depth, and all rows are equally long."""
    if isinstance(value, list):
        return all(map(_numbers, value)) and len({len(v) if isinstance(v, list) else -1 for v in value}) <= 1
    return value is None or (isinstance(value, (int, float)) and not isinstance(value, bool))


def _converted(key: str, value: Any) -> Any:
    if isinstance(value, dict):
        return Document({k: _converted(k, v) for k, v in value.items()})
    if not isinstance(value, list):
        return value
    # Names of what a law has not are nulls too.
    if not _numbers(value) or (value == [] and key in _lists) or key in ("inputs", "outputs"):
        return [_converted(key, v) for v in value]
    if key in _complex:
        pairs = np.array(value, dtype=float)
        return pairs.reshape(-1, 2).view(complex).reshape(pairs.shape[:-1]) if pairs.size else np.zeros(0, dtype=complex)
    return np.array(value, dtype=int if key in _whole else float)  # null is NaN


class Document:
    """An answer: its keys are attributes, and as in a dict there are document["key"], `in`, len, keys(), values(), items() and
    get(). A key of such a name wins: then vars(document) is the dict. null is None, and NaN inside arrays (float64;
    complex128 where the program gives pairs; int64 of counts). Which keys, shapes and units: docs/json. The classes
    derived from it declare those that are always there."""

    if TYPE_CHECKING:
        def keys(self) -> KeysView[str]: ...

    def __init__(self, keys: Mapping[str, Any] = {}, **more: Any) -> None:
        vars(self).update(keys, **more)

    def __getattr__(self, name: str) -> Any:
        # Only for what is no key. Methods that were inherited would be said again in the help of each class.
        if hasattr(dict, name) and not name.startswith("_"):
            return getattr(vars(self), name)
        raise AttributeError(f"no key {name!r}; there are {', '.join(self)}")

    def __getitem__(self, key: str) -> Any:
        return vars(self)[key]

    def __iter__(self) -> Iterator[str]:
        return iter(vars(self))

    def __len__(self) -> int:
        return len(vars(self))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Document) and vars(self) == vars(other)

    @staticmethod
    def _short(value: Any) -> str:
        if isinstance(value, np.ndarray):
            text = np.array2string(value, precision=5, threshold=8) if value.size <= 8 else f"{value.dtype.name} {value.shape}"
        elif isinstance(value, Document):
            text = "{" + ", ".join(value) + "}"
        elif isinstance(value, list) and len(value) > 6:
            text = f"list of {len(value)}"
        else:
            text = repr(value)
        return text if len(text) <= 100 else text[:97] + "..."

    def __repr__(self) -> str:
        width = max(map(len, self), default=0)
        lines = [f"  {key:<{width}}  {self._short(value)}" for key, value in vars(self).items()]
        return "\n".join([type(self).__name__, *lines])

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th style='text-align:left'>{html.escape(key)}</th>"
            f"<td style='text-align:left'><code>{html.escape(self._short(value))}</code></td></tr>"
            for key, value in vars(self).items()
        )
        return f"<table>{rows}</table>"


# For isinstance: a document can be given as a block.
Mapping.register(Document)


Kind = TypeVar("Kind", bound=Document)


def document(raw: Mapping[str, Any], kind: Type[Kind]) -> Kind:
    """A document of the program; raw: what json.loads made of it."""
    return kind({key: _converted(key, value) for key, value in raw.items()})
