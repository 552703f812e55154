"""Documents of the program as Python objects: keys are attributes, lists of numbers are numpy arrays."""

import html
import os
from typing import Any, Dict, List, Mapping, Type, TypeVar, Union

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]

# A file, or a block of its keys (a controller, a floor); None: the scene's own.
Path = Union[str, "os.PathLike[str]"]
Block = Union[Path, Mapping[str, Any], None]
# What an option of the program may be.
Option = Union[Block, bool, float]

# Pairs [re, im] in JSON.
_complex = {"eigenvalues", "closed_loop_poles"}


def _numbers(value: Any) -> bool:
    """Whether a list holds numbers and nulls alone, at any depth, and all rows are equally long."""
    if isinstance(value, list):
        return len(value) > 0 and all(map(_numbers, value)) and len({len(v) if isinstance(v, list) else -1 for v in value}) == 1
    return value is None or (isinstance(value, (int, float)) and not isinstance(value, bool))


def _converted(key: str, value: Any) -> Any:
    if isinstance(value, dict):
        return Document({k: _converted(k, v) for k, v in value.items()})
    if not isinstance(value, list):
        return value
    if _numbers(value) and any(v is not None for v in np.array(value, dtype=object).ravel()):
        array = np.array(value, dtype=float)  # null is NaN
        return array[..., 0] + 1j * array[..., 1] if key in _complex and array.shape[-1:] == (2,) else array
    if value == []:
        return np.zeros(0, dtype=complex) if key in _complex else value
    return [_converted(key, v) for v in value]


class Document(Dict[str, Any]):
    """A dict whose keys are attributes too. null is None, and NaN inside arrays (float64, or complex128 where the program
    gives pairs). Which keys, shapes and units: docs/json. The classes derived from it declare those that are always there."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no key {name!r}; there are {', '.join(self)}") from None

    def __dir__(self) -> List[str]:
        return [*super().__dir__(), *self]

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
        lines = [f"  {key:<{width}}  {self._short(value)}" for key, value in self.items()]
        return "\n".join([type(self).__name__, *lines])

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th style='text-align:left'>{html.escape(key)}</th>"
            f"<td style='text-align:left'><code>{html.escape(self._short(value))}</code></td></tr>"
            for key, value in self.items()
        )
        return f"<table>{rows}</table>"


Kind = TypeVar("Kind", bound=Document)


def document(raw: Mapping[str, Any], kind: Type[Kind]) -> Kind:
    """A document of the program; raw: what json.loads made of it."""
    return kind({key: _converted(key, value) for key, value in raw.items()})
