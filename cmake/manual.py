#!/usr/bin/env python3
"""Writes manual pages and completion for bash from what the programs' --help says.

usage: manual.py FOLDER_OF_PROGRAMS DATA_FOLDER

DATA_FOLDER/man/man1 gets a page for each program and each verb, DATA_FOLDER/bash-completion/completions one file."""

import gzip
import pathlib
import re
import subprocess
import sys

PROGRAMS = ("stillframe", "stillframe-controller", "stillframe-plant")


def said(program, *arguments):
    # Called by its name, which its help says.
    return subprocess.run([pathlib.Path(program).name, *arguments], executable=program, check=True, capture_output=True,
                          text=True).stdout


class Help:
    """What a --help says: a sentence, how to call it, tables of names and words, and the rest."""

    def __init__(self, text):
        head, _, rest = text.partition("Usage: ")
        self.description = " ".join(head.split())
        self.usage, _, rest = rest.partition("\n")
        self.tables, self.footer = [], ""
        lines = rest.split("\n")
        at = 0
        while at < len(lines):
            title = re.fullmatch(r"(\w[\w ]*):", lines[at])
            # A name and words beside it, or below it: an example has none.
            is_table = title and re.match(r"  \S.*?  +\S|  \S.*\n   +\S", "\n".join(lines[at + 1:at + 3]))
            if not is_table or self.footer.strip():
                self.footer += lines[at] + "\n"
                at += 1
                continue
            entries = []
            at += 1
            while at < len(lines) and lines[at].startswith("  "):
                entry = re.match(r"  (\S.*?)(?:  +(\S.*))?$", lines[at])
                if entry:
                    entries.append([entry[1], entry[2] or ""])
                else:
                    entries[-1][1] = (entries[-1][1] + " " + lines[at].strip()).strip()
                at += 1
            self.tables.append((title[1], entries))
        self.footer = self.footer.strip("\n")

    def table(self, *titles):
        return [entry for title, entries in self.tables if title in titles for entry in entries]

    def verbs(self):
        """Name to what it does, of a program."""
        known = ("Positionals", "Options")
        return {name: words for title, entries in self.tables if title not in known for name, words in entries}

    def options(self):
        return [word for name, _ in self.table("Options") for word in re.findall(r"(?<![\w-])--?[\w-]+", name)]


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\n".join("\\&" + line if line.startswith((".", "'")) else line for line in text.split("\n"))


def page(name, version, text, see_also):
    help_ = Help(text)
    # A program says its name and more than one sentence.
    first, _, more = help_.description.removeprefix(name + ": ").partition(". ")
    out = [f'.TH "{name.upper()}" 1 "" "stillframe {version}" "stillframe"', ".SH NAME",
           f"{roff(name)} \\- {roff(first)}", ".SH SYNOPSIS", roff(help_.usage)]
    if more:
        out += [".SH DESCRIPTION", roff(more)]
    for title, entries in help_.tables:
        out.append(f'.SH "{roff(title.upper())}"')
        for entry, words in entries:
            out += [".TP", f"\\fB{roff(entry)}\\fR", roff(words) or "\\&"]
    if help_.footer:
        out += [".SH NOTES", ".nf", roff(help_.footer), ".fi"]
    out += [".SH SEE ALSO", roff(", ".join(f"{other}(1)" for other in see_also if other != name)), ""]
    return "\n".join(out)


def completion(helps, verbs):
    """A file for bash: options where a word begins with a dash, verbs first, else files."""
    cases = []
    for verb, help_ in verbs.items():
        cases.append(f'    {verb}) options="{" ".join(help_.options())}" ;;')
    for program in PROGRAMS[1:]:
        cases.append(f'    {program}) options="{" ".join(helps[program].options())}" ;;')
    return f'''# bash completion of stillframe, written from --help.
_stillframe() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} which=${{COMP_WORDS[0]##*/}} options=""
  if [ "$which" = stillframe ]; then
    if [ "$COMP_CWORD" -eq 1 ]; then
      mapfile -t COMPREPLY < <(compgen -W "{" ".join(list(verbs) + helps["stillframe"].options())}" -- "$word")
      return
    fi
    which=${{COMP_WORDS[1]}}
  fi
  case "$which" in
{chr(10).join(cases)}
  esac
  case "$word" in
    -*) mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word") ;;
    *) mapfile -t COMPREPLY < <(compgen -f -- "$word") ;;
  esac
}}
complete -o filenames -F _stillframe {" ".join(PROGRAMS)}
'''


def main(folder, data):
    programs = {name: str(pathlib.Path(folder) / name) for name in PROGRAMS}
    version = said(programs["stillframe"], "--version").split()[-1]
    texts = {name: said(path, "--help") for name, path in programs.items()}
    verbs = {verb: said(programs["stillframe"], verb, "--help") for verb in Help(texts["stillframe"]).verbs()}
    pages = {**texts, **{f"stillframe-{verb}": text for verb, text in verbs.items()}}
    manual = pathlib.Path(data) / "man" / "man1"
    manual.mkdir(parents=True, exist_ok=True)
    for name, text in pages.items():
        see_also = sorted(pages) if name == "stillframe" else PROGRAMS
        # Without a time in it: the same package for the same source.
        (manual / f"{name}.1.gz").write_bytes(gzip.compress(page(name, version, text, see_also).encode(), mtime=0))
    completions = pathlib.Path(data) / "bash-completion" / "completions"
    completions.mkdir(parents=True, exist_ok=True)
    text = completion({name: Help(text) for name, text in texts.items()},
                      {verb: Help(text) for verb, text in verbs.items()})
    for name in PROGRAMS:  # bash looks for a file of the program's name
        (completions / name).write_text(text)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
