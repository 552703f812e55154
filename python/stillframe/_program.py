"""The program behind the module: where it is, how it is called, and what it says when something is wrong."""

import difflib
import json
import numbers
import os
import pathlib
import re
import shutil
import subprocess
import sys
import warnings
from typing import Any, Callable, Dict, Iterable, Mapping, Optional, Sequence, Tuple, Type


# --option: FILE:LINE:COLUMN: key: what is wrong; or FILE alone. A key may have the shape of a file's name.
_place = re.compile(r"(?:--[\w-]+: )?(?:(?P<file>[^\n]*?):(?P<line>\d+):\d+: |(?P<whole>/[^\n:]*|<\w+>|[^\s:]*\.(?:ya?ml|lcm)): )?"
                    r"(?P<key>[^\s:]+(?=: ))?(?:: )?(?:the key '(?P<missing>[^']+)' is missing)?")


class ProgramError(RuntimeError):
    """What the program says on standard error, with its exit code.

    message: str; exit_code: int; file, line, key: where the message names them, else None."""

    file: Optional[str]
    line: Optional[int]
    key: Optional[str]

    def __init__(self, message: str, exit_code: int = 1) -> None:
        super().__init__(message)
        self.message, self.exit_code = message, exit_code
        place = _place.match(message)
        assert place  # it matches nothing too
        self.file = place["file"] or place["whole"]
        self.line = int(place["line"]) if place["line"] else None
        self.key = ".".join(filter(None, (place["key"], place["missing"]))) or None if place.start("key") else None


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
    """Prints the help of the program, or of one of its verbs: options with defaults, keys of the answer. help("scene"): the
    keys of a scene. Raises InputError for another word."""
    said = _run(["--help"])[1]
    verbs = ["scene", *re.findall(r"^  (\w+)  ", said, re.MULTILINE)]
    if verb and verb not in verbs:
        raise InputError(f"help: no verb {verb!r}{meant(verb, verbs)}", 2)
    if verb == "scene":
        # Beside the program: in the sources, or as installed.
        places = [folder / place for path in (__file__, program()) for folder in pathlib.Path(path).resolve().parents
                  for place in ("docs/scene.md", "share/stillframe/docs/scene.md")]
        found = [path for path in places if path.exists()]
        said = found[0].read_text(encoding="utf-8") if found else (
            "docs/scene.md in the sources of stillframe has the keys of a scene; scenes are in share/stillframe/config/scenes.")
    elif verb:
        said = _run([verb, "--help"])[1]
    print(said)


def meant(word: object, allowed: Iterable[str]) -> str:
    """For messages: what may have been meant by a word, and what is allowed."""
    allowed = list(allowed)
    near = difflib.get_close_matches(str(word), allowed, 1)
    return (f" (did you mean {near[0]!r}?)" if near else "") + f"; allowed: {', '.join(allowed)}"


def _words(name: str, value: object) -> Sequence[object]:
    """The words of an option, none if its value is None or False."""
    option = "--" + name.replace("_", "-")
    if value is None or value is False:
        return []
    if value is True:
        return [option + "=true"]  # of what is no flag the program says that it is none
    return [option, _word(name, value)]


def _word(name: str, value: object) -> object:
    if not isinstance(value, (str, os.PathLike, numbers.Real)):
        raise InputError(f"{name}: found {type(value).__name__}, allowed is a path, a text or a number", 2)
    return repr(float(value)) if isinstance(value, float) else value


def _level() -> int:
    """The stacklevel, seen from the caller, of who called the module."""
    frame, level = sys._getframe(1), 1
    while frame.f_back and frame.f_globals.get("__package__") == __package__:
        frame, level = frame.f_back, level + 1
    return level


def _run(arguments: Sequence[object]) -> Tuple[int, str, str]:
    done = subprocess.run([program(), *map(str, arguments)], capture_output=True, check=False)
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def _said(error: str, verb: str) -> str:
    """Without the name of the program and the level."""
    error = error.replace("Run with --help", f'stillframe.help("{verb}")').replace("for more information", "says more")
    lines = [re.sub(r"^stillframe: (error: )?", "", line) for line in error.splitlines()]
    return "\n".join(line for line in lines if line).strip()


def call(verb: str, *arguments: object, options: Optional[Mapping[str, Any]] = None, answers: Tuple[int, ...] = (0,),
         names: Mapping[str, str] = {}, failed: Callable[[Any], Iterable[str]] = lambda found: ()) -> Any:
    """The document of `stillframe VERB ARGUMENTS --json`. options: {name: value}; what is None or False is left out,
    True is a flag, a list is given again for each item. answers: exit codes that come with a document. names: {path: name}
    for messages. failed: what of a document is behind exit code 4, where the program does not say it."""
    words: list[object] = [verb, *(_word(verb, argument) for argument in arguments)]
    for name, value in (options or {}).items():
        for item in value if isinstance(value, (list, tuple)) else [value]:
            words += _words(name, item)
    code, output, error = _run([*words, "--json"])
    for path, name in names.items():
        error = error.replace(path, name)
    if code not in answers or not output:
        if "arguments were not expected" in error:
            # Examples, further down, have options too.
            listed = _run([verb, "--help"])[1].split("\nOptions:\n")[1].split("\n\n")[0]
            allowed = [name.replace("-", "_") for name in re.findall(r"^  --([\w-]+)", listed, re.MULTILINE) if name != "json"]
            for name in [name for name in options or {} if name not in allowed]:
                raise InputError(f"{verb}: no option {name!r}{meant(name, allowed)}", 2)
        raise _errors.get(code, ProgramError)(_said(error, verb), code)
    found = json.loads(output)
    for line in [*_said(error, verb).splitlines(), *(f"{verb}: {text}" for text in failed(found) if code == 4)]:
        warnings.warn(line, stacklevel=_level())
    return found
