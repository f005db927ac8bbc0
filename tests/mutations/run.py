#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Breaks copies of the product on purpose and shows that the soak's oracle notices.

usage: run.py [--build FOLDER] [NAME...]   (default: every patch beside this script)
Each patch names in its first line the kind of violation that it must cause. The tree is copied, one patch is applied to
the copy, gateway_soak is built there and run until the violation shows. The copy keeps its build between patches, so
that only what changed is compiled again.
"""

import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SEEDS = 200
TRANSACTIONS = 500


def run(command, **options):
    return subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, **options)


def build(tree, folder):
    if not (folder / "build.ninja").exists():
        made = run(["cmake", "-S", tree, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release"])
        if made.returncode != 0:
            sys.exit(made.stdout)
    made = run(["ninja", "-C", folder, "gateway_soak"])
    return made.stdout if made.returncode != 0 else ""


def violations(folder):
    """How often each kind of violation was seen."""
    soak = run([folder / "bin" / "gateway_soak", "--seeds", str(SEEDS), "--transactions", str(TRANSACTIONS)])
    line = re.findall(r"^  violations: (.*)$", soak.stdout, re.MULTILINE)
    words = line[-1].split() if line and line[-1] != "none" else []
    return dict(zip(words[::2], map(int, words[1::2])))


def check(patch, tree, folder):
    """A line of the table, and whether the violation showed."""
    expected = patch.read_text(encoding="utf-8").splitlines()[0].removeprefix("Expect: ")
    if run(["patch", "-p1", "-i", patch], cwd=tree).returncode != 0:
        return f"{patch.stem}: does not apply any more", False
    try:
        trouble = build(tree, folder)
        if trouble:
            return f"{patch.stem}: does not build\n{trouble}", False
        seen = violations(folder)
    finally:
        run(["patch", "-R", "-p1", "-i", patch], cwd=tree)
    return f"{patch.stem}: expected {expected}, seen {seen}", seen.get(expected, 0) > 0


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", type=pathlib.Path, help="keeps copy and build here")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    work = options.build or pathlib.Path(tempfile.mkdtemp(prefix="mbgate-mutations-"))
    tree = work / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    for part in ("src", "tests", "conf"):
        shutil.copytree(ROOT / part, tree / part)
    shutil.copy2(ROOT / "CMakeLists.txt", tree)
    missed = 0
    trouble = build(tree, work / "build")
    if trouble:
        sys.exit(f"the copy does not build\n{trouble}")
    unbroken = violations(work / "build")
    if unbroken:
        print(f"WARNING: without any patch there is already {unbroken}", flush=True)
    for patch in sorted(HERE.glob("*.patch")):
        if not options.names or patch.stem in options.names:
            text, caught = check(patch, tree, work / "build")
            print(("caught  " if caught else "MISSED  ") + text, flush=True)
            missed += not caught
    if options.build is None:
        shutil.rmtree(work)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
