#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Which libraries each program needs to run, with the package, version and licence of each on this machine. The
programs are those in the folder MBGATE_PROGRAMS, else the installed ones, or those that are named.

`--check` compares the names with docs/linked-libraries.md, `--update` writes them there. Versions are not in it: what
is installed is what counts."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

SKIPPED = 77
PROGRAMS = ("mbgated", "mbgate-signer", "mbgatectl", "mbgate-sim", "mbgate-bench")
PAGE = pathlib.Path(__file__).parents[2] / "docs/linked-libraries.md"
# Only in test builds.
OF_SANITIZERS = re.compile(r"lib(asan|ubsan|gcov)\b")
# What every program has, and names by itself or not as the compiler likes.
RUNTIME = {"libc", "libm", "libgcc_s", "libstdc++", "libatomic"}
# Comes with another one, and is named by some linkers only.
PERHAPS = {"libboost_container"}


def output(*command):
    """What a command says; nothing if it fails."""
    done = subprocess.run(command, check=False, text=True, capture_output=True, env=os.environ | {"LC_ALL": "C.UTF-8"})
    return done.stdout if done.returncode == 0 else ""


def path_of(program):
    folder = os.environ.get("MBGATE_PROGRAMS", os.environ.get("PATH", "") + ":/usr/sbin")
    return shutil.which(program, path=folder)


def needed(path):
    """The libraries that an ELF file names itself."""
    names = re.findall(r"\(NEEDED\).*\[(.*)\]", output("readelf", "--wide", "--dynamic", path))
    return sorted(name for name in names if not OF_SANITIZERS.match(name))


def names_of(path):
    """Without their versions, and what every program has."""
    names = {name.partition(".so")[0] for name in needed(path)}
    return {name for name in names if name not in RUNTIME and not name.startswith("ld-linux")}


def where(path):
    """Library to file, as the loader finds them."""
    return dict(re.findall(r"^\s*(\S+) => (/\S+)", output("ldd", path), re.MULTILINE))


def package_of(file):
    """The Debian package and version of a file, and where its licence is."""
    for name in (file, os.path.realpath(file), os.path.realpath(file).removeprefix("/usr")):
        found = output("dpkg", "-S", name).partition(": ")[0].partition(",")[0]
        if found:
            version = output("dpkg-query", "-W", "-f", "${Version}", found)
            return found.partition(":")[0], version, f"/usr/share/doc/{found.partition(':')[0]}/copyright"
    return "-", "-", "-"


def show(paths):
    for path in paths:
        print(f"{path}:")
        files = where(path)
        for name in needed(path):
            package, version, licence = package_of(files.get(name, name))
            print(f"  {name:<32} {package:<28} {version:<24} {licence}")


def written():
    """Program to the names that stand in the document."""
    rows = re.findall(r"^\| (mbgate\S*) \| (.*) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    return {program: set(re.findall(r"`([^`]+)`", names)) for program, names in rows}


def differences(libraries, there):
    """What stands in the document and is not true, or the other way round."""
    wrong = [f"{program} has no row" for program in libraries.keys() - there.keys()]
    for program, names in there.items():
        found = libraries.get(program, set())
        wrong += [f"{program} needs {name}, which is not written" for name in sorted(found - names)]
        wrong += [f"{program} does not need {name}, which is written" for name in sorted(names - found - PERHAPS)]
    return wrong


def update(libraries):
    rows = [f"| {program} | {', '.join(f'`{name}`' for name in sorted(libraries[program])) or 'no others'} |\n"
            for program in PROGRAMS]
    head = "| program | libraries |\n|---|---|\n"
    text = PAGE.read_text(encoding="utf-8")
    text = re.sub(re.escape(head) + r"(?:\|.*\n)*", lambda _: head + "".join(rows), text)
    PAGE.write_text(text, encoding="utf-8")


def main():
    words = [word for word in sys.argv[1:] if word.startswith("--")]
    paths = [word for word in sys.argv[1:] if not word.startswith("--")]
    paths = paths or [path for path in map(path_of, PROGRAMS) if path]
    if not shutil.which("readelf") or not paths:
        print("skipped: readelf (binutils) or the programs are not there")
        return SKIPPED
    if not words:
        show(paths)
        return 0
    libraries = {pathlib.Path(path).name: names_of(path) for path in paths}
    if set(libraries) != set(PROGRAMS):
        print(f"skipped: not all programs are there, only {', '.join(libraries)}")
        return SKIPPED
    if "--update" in words:
        update(libraries)
    assert differences({"a": {"libnew"}}, {"a": {"libold"}}), "a difference is not seen"
    wrong = differences(libraries, written())
    print("\n".join(wrong + [f"{PAGE.name}: {'--update mends it' if wrong else 'is right'}"]))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
