#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Breaks copies of the product on purpose and shows that the judge notices.

usage: run.py [--check] [--build FOLDER] [--seeds N] [--transactions N] [--tries N] [--jobs N] [NAME...]

Each patch names in its first line the kind of violation that it must cause, or "any" of them. An assertion of the product
counts as any of them (broken_invariant). The tree is copied for each job, one patch at a time is applied to a copy, the
soak is built there and run; a line of the table of tests/README.md is printed for each, with the seed that shows it first.
Where the first seeds show nothing, others are tried. Copies and builds are kept in --build, so that only what a patch
changes is compiled again, by ccache where there is one. --check only says whether every patch still applies.

Exits 1 if a violation did not show, or a patch does not apply.
"""

import argparse
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
from typing import NamedTuple

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PARTS = ("CMakeLists.txt", "cmake", "src", "tests", "bench", "conf", "tools", "systemd", "debian")
SKIPPED = 77  # what ctest takes for a test that could not be run
# What takes more memory, or more seconds of the processor, does not end by itself.
MOST_MEMORY = 4 << 30
MOST_SECONDS = 900
SOAK = ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG"]  # compiling takes longer than the seeds


def run(command, **options):
    return subprocess.run(command, text=True, errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                          **options)


def limited(command):
    limits = ["prlimit", f"--as={MOST_MEMORY}", f"--cpu={MOST_SECONDS}"] if shutil.which("prlimit") else []
    return run([*limits, *command])


def git_apply(tree, patch, *options):
    """All of the patch or nothing of it. The tree is none of a repository around it: git would leave its files alone."""
    surroundings = os.environ | {"GIT_CEILING_DIRECTORIES": str(tree.parent)}
    return run(["git", "apply", "--whitespace=nowarn", *options, patch], cwd=tree, env=surroundings)


def expected_of(patch):
    return re.match(r"Expect: (\w+)\n", patch.read_text(encoding="utf-8")).group(1)


def files_of(root):
    """Path below the root and content of every file that the soak is made of."""
    found = {}
    for part in PARTS:
        top = root / part
        for file in [top] if top.is_file() else sorted(top.rglob("*")):
            if file.is_file() and "__pycache__" not in file.parts:
                found[file.relative_to(root)] = file.read_bytes()
    return found


def synchronize(tree):
    """Makes the tree a copy of ours. What is the same keeps its time, what differs is new to the build."""
    ours = files_of(ROOT)
    theirs = files_of(tree) if tree.exists() else {}
    for name in theirs.keys() - ours.keys():
        (tree / name).unlink()
    for name, content in ours.items():
        if theirs.get(name) != content:
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            (tree / name).write_bytes(content)


class Copy:
    """A copy of the tree in which one patch at a time is tried."""

    def __init__(self, work):
        self.tree = work / "tree"
        self.soak = self.tree / "build/mutation"  # as deep as the builds of the presets: ccache knows their objects
        synchronize(self.tree)

    def build(self, folder, how, targets, jobs=1):
        """What went wrong; nothing if nothing did."""
        surroundings = os.environ | {"CCACHE_BASEDIR": str(self.tree), "CCACHE_NOHASHDIR": "1"}
        if not (folder / "build.ninja").exists():
            launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
            made = run(["cmake", "-S", self.tree, "-B", folder, "-G", "Ninja", *how, *launcher])
            if made.returncode != 0:
                return made.stdout
        made = run(["ninja", "-C", folder, "-j", str(jobs), *targets], env=surroundings)
        return made.stdout if made.returncode != 0 else ""

    def build_soak(self, jobs=1):
        return self.build(self.soak, SOAK, ["soak"], jobs)


class Seen(NamedTuple):
    """What a soak has told: how often each kind of violation was seen, and in which seed first. Of one that died only what
    it had told by then."""

    counts: dict
    seeds: dict
    died: bool


# What the product has noticed by itself: one of its invariants, or one of the standard library's.
BROKEN = re.compile(r"broken invariant: |: Assertion '.*' failed")


def seen_in(text):
    seeds, told = {}, {}
    for seed, kind in re.findall(r"^seed (\d+): (\w+): ", text, re.MULTILINE):
        seeds.setdefault(kind, int(seed))
        told[kind] = told.get(kind, 0) + 1
    if not re.search(r"^\d+ seeds, \d+ with violations", text, re.MULTILINE):
        broken = bool(BROKEN.search(text))
        return Seen(told | {"broken_invariant": 1} if broken else told, seeds, not broken)
    words = " ".join(re.findall(r"^  violations: (.*)$", text, re.MULTILINE)).split()
    return Seen(dict(zip(words[::2], map(int, words[1::2]))), seeds, False)


def kind_of(expected, seen):
    """The violation that shows the patch, or nothing. Of any of them, the one that is seen first."""
    if expected != "any":
        return next((kind for kind in (expected, "broken_invariant") if kind in seen.counts), None)
    return min(seen.counts, key=lambda kind: (seen.seeds.get(kind, sys.maxsize), -seen.counts[kind]), default=None)


def soak(copy, first, options):
    return seen_in(limited([copy.soak / "bin/soak", "--seed", str(first), "--seeds", str(options.seeds),
                            "--transactions", str(options.transactions)]).stdout)


def see(expected, copy, options):
    """The violation, the seed that shows it first, how often it was seen in the first seeds; and whether a soak died."""
    died = False
    for attempt in range(options.tries):
        seen = soak(copy, 1 + attempt * options.seeds, options)
        died = died or seen.died
        kind = kind_of(expected, seen)
        if kind:
            return kind, seen.seeds.get(kind, "?"), seen.counts.get(kind, 1) if attempt == 0 else 0, died
    return None, None, 0, died


def try_patch(patch, copy, options):
    """A line of the table; and whether the patch was seen."""
    applied = git_apply(copy.tree, patch)
    if applied.returncode != 0:
        return f"{patch.stem}: does not apply any more\n{applied.stdout}", False
    try:
        trouble = copy.build_soak()
        if trouble:
            return f"{patch.stem}: does not build\n{trouble}", False
        expected = expected_of(patch)
        kind, seed, count, died = see(expected, copy, options)
        note = " (a soak died)" if died else ""
        if kind:
            return f"| {patch.stem} | {kind}{note} | {seed} | {count} |", True
        return f"| {patch.stem} | MISSED{note} | | |", False
    finally:
        git_apply(copy.tree, patch, "--reverse")


def try_all(patches, copies, options):
    """Prints the table, in the order in which it comes to be; true if all were seen."""
    waiting = list(reversed(patches))
    lock = threading.Lock()

    def work_off(copy):
        good = True
        while True:
            with lock:
                if not waiting:
                    return good
                patch = waiting.pop()
            line, seen = try_patch(patch, copy, options)
            good = good and seen
            with lock:
                print(line, flush=True)

    with concurrent.futures.ThreadPoolExecutor(len(copies)) as pool:
        return all(list(pool.map(work_off, copies)))


def check(patches):
    """Do all of them apply?"""
    if shutil.which("git") is None:
        print("there is no git, which applies them")
        return SKIPPED
    known = "".join(file.read_text(encoding="utf-8") for folder in ("world", "judge")
                    for file in sorted((ROOT / "tests" / folder).glob("*.?pp")))
    good = True
    for patch in patches:
        applied = git_apply(ROOT, patch, "--check")
        expected = expected_of(patch)
        if applied.returncode != 0:
            print(f"{patch.stem}: does not apply any more\n{applied.stdout}")
            good = False
        elif expected != "any" and f'"{expected.removeprefix("drill_")}"' not in known:
            print(f"{patch.stem}: the soak knows no violation {expected}")
            good = False
    print(f"{len(patches)} patches: {'all apply' if good else 'not all apply'}")
    return 0 if good else 1


def options_of(patches):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="only say whether the patches apply")
    parser.add_argument("--build", type=pathlib.Path, help="keeps copies and builds here")
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--transactions", type=int, default=500)
    parser.add_argument("--tries", type=int, default=5, help="so often so many seeds, until one shows it")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="patches that are tried at a time")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    unknown = set(options.names) - {patch.stem for patch in patches}
    if unknown:
        parser.error(f"no such patch: {', '.join(sorted(unknown))}")
    return options


def main():
    patches = sorted(HERE.glob("*.patch"))
    options = options_of(patches)
    patches = [patch for patch in patches if not options.names or patch.stem in options.names]
    if options.check:
        return check(patches)
    work = (options.build or pathlib.Path(tempfile.mkdtemp(prefix="mbgate-mutations-"))).resolve()
    copies = [Copy(work / str(number)) for number in range(min(options.jobs, len(patches)))]
    for copy in copies:
        trouble = copy.build_soak(options.jobs)
        if trouble:
            sys.exit(f"the copy does not build\n{trouble}")
    unbroken = soak(copies[0], 1, options)
    if unbroken.counts or unbroken.died:
        print(f"WARNING: without any patch there is already {unbroken}", flush=True)
    print(f"| patch | seen by | first in seed | in seeds 1 to {options.seeds}, {options.transactions} transactions each |\n"
          "|---|---|---|---|", flush=True)
    good = try_all(patches, copies, options)
    if options.build is None:
        shutil.rmtree(work)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
