"""The program behind the module: where it is, how it is called, and what it says when something is wrong."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import warnings
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple, Type


class ProgramError(RuntimeError):
    """What the program says on standard error, with its exit code.

    message: str; exit_code: int; file, line, key: where the message names them, else None."""

    file: Optional[str]
    line: Optional[int]
    key: Optional[str]

    def __init__(self, message: str, exit_code: int = 1) -> None:
        super().__init__(message)
        self.message, self.exit_code = message, exit_code
        place = re.match(r"(?P<file>[^\n]*?):(?P<line>\d+):\d+: (?:(?P<key>[^\s:]+): )?", message)
        self.file = place["file"] if place else None
        self.line = int(place["line"]) if place else None
        self.key = place["key"] if place else None


class InputError(ProgramError):
    """Bad usage or input (exit code 2): what was found, and what is allowed."""


class Refusal(ProgramError):
    """What was asked for has no sound answer (exit code 3): an unstable loop, no equilibrium."""


class RunFailed(ProgramError):
    """A run, or a part of what was asked, has not come about (exit code 4)."""


# A relative STILLFRAME is of where the notebook was started, whatever folder it goes to.
_started = pathlib.Path.cwd()

_errors: Dict[int, Type[ProgramError]] = {2: InputError, 3: Refusal, 4: RunFailed}


def program(name: str = "stillframe") -> str:
    """The path of a program: beside $STILLFRAME if that is set (the path of `stillframe`, a relative one from the
    folder of the import), else on $PATH.

    Raises ProgramError where there is none."""
    given = os.environ.get("STILLFRAME")
    found = str((_started / given).parent / name) if given else shutil.which(name)
    if not found or not os.access(found, os.X_OK):
        where = f"beside {given}, which STILLFRAME names" if given else "on PATH"
        raise ProgramError(f"no program {name} {where}; install it, or set STILLFRAME to the path of `stillframe`")
    return found


def version() -> str:
    """The version of the program, as a text."""
    return _run(["--version"])[1].strip()


def help(verb: str = "") -> None:
    """Prints the help of the program, or of one of its verbs."""
    print(_run([verb, "--help"] if verb else ["--help"])[1])


def _run(arguments: Sequence[object]) -> Tuple[int, str, str]:
    done = subprocess.run([program(), *map(str, arguments)], capture_output=True, check=False)
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def _said(error: str) -> str:
    """Without the name of the program and the level."""
    lines = [re.sub(r"^stillframe: (error: )?", "", line) for line in error.splitlines()]
    return "\n".join(line for line in lines if line).strip()


def call(verb: str, *arguments: object, options: Optional[Mapping[str, Any]] = None, answers: Tuple[int, ...] = (0,),
         rename: Optional[Tuple[str, str]] = None) -> Any:
    """The document of `stillframe VERB ARGUMENTS --json`. options: {name: value}; what is None or False is left out,
    True is a flag, a list is given again for each item. answers: exit codes that come with a document. rename: (path, name) for messages."""
    words: list[object] = [verb, *arguments]
    for name, value in (options or {}).items():
        option = "--" + name.replace("_", "-")
        for item in value if isinstance(value, (list, tuple)) else [value]:
            if item is None or item is False:
                continue
            words += [option] if item is True else [option, repr(item) if isinstance(item, float) else item]
    code, output, error = _run([*words, "--json"])
    if rename:
        error = error.replace(*rename)
    if code not in answers or not output:
        raise _errors.get(code, ProgramError)(_said(error), code)
    for line in _said(error).splitlines():
        warnings.warn(line, stacklevel=5)
    return json.loads(output)
