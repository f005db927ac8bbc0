#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Breaks copies of the product on purpose and shows that the soak's oracle notices.

usage: run.py [--check] [--build FOLDER] [--seeds N] [--transactions N] [--jobs N] [NAME...]   (default: every patch)

Each patch names in its first line the kind of violation that it must cause, or "any". The tree is copied, one patch at
a time is applied to the copy, gateway_soak is built there and run; a line of the table of tests/README.md is printed for
each. Where the first seeds show nothing, others are tried. Copy and build are kept in --build, so that only what a patch
changes is compiled again, by ccache where there is one. --check only says whether every patch still applies.

Exits 1 if a violation did not show, or a patch does not apply.
"""

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PARTS = ("CMakeLists.txt", "src", "tests", "bench", "conf")
# How often more seeds are tried for a violation that the first ones did not show.
MORE_TRIES = 4
SKIPPED = 77  # what ctest takes for a test that could not be run


def run(command, **options):
    return subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, **options)


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


def build(tree, folder, jobs):
    """What went wrong; nothing if nothing did."""
    surroundings = os.environ | {"CCACHE_BASEDIR": str(tree), "CCACHE_NOHASHDIR": "1"}
    if not (folder / "build.ninja").exists():
        launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
        made = run(["cmake", "-S", tree, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", *launcher])
        if made.returncode != 0:
            return made.stdout
    made = run(["ninja", "-C", folder, *(["-j", str(jobs)] if jobs else []), "gateway_soak"], env=surroundings)
    return made.stdout if made.returncode != 0 else ""


def violations(folder, first, options):
    """How often each kind of violation was seen, and in which seed first. Of a soak that died only what it had told."""
    soak = run([folder / "bin" / "gateway_soak", "--seed", str(first), "--seeds", str(options.seeds),
                "--transactions", str(options.transactions)])
    seeds, told = {}, {}
    for seed, kind in re.findall(r"^seed (\d+): (\w+): ", soak.stdout, re.MULTILINE):
        seeds.setdefault(kind, seed)
        told[kind] = told.get(kind, 0) + 1
    line = re.findall(r"^  violations: (.*)$", soak.stdout, re.MULTILINE)
    if not line:
        print(f"    the soak died: {soak.stdout.strip().splitlines()[-1:]}", file=sys.stderr, flush=True)
        return told, seeds
    words = line[-1].split() if line[-1] != "none" else []
    return dict(zip(words[::2], map(int, words[1::2]))), seeds


def see(expected, folder, options):
    """The violation, a text that says how often it was seen, and all that was; no text if it was not."""
    seen = {}
    for attempt in range(1 + MORE_TRIES):
        seen, seeds = violations(folder, 1 + attempt * options.seeds, options)
        kind = max(seen, key=seen.get, default=expected) if expected == "any" else expected
        if kind in seen:
            return kind, str(seen[kind]) if attempt == 0 else f"first in seed {seeds.get(kind, '?')}", seen
    return expected, "", seen


def try_patch(patch, tree, folder, options):
    """Prints a line of the table; true if the violation showed."""
    applied = git_apply(tree, patch)
    if applied.returncode != 0:
        print(f"{patch.stem}: does not apply any more\n{applied.stdout}", flush=True)
        return False
    try:
        trouble = build(tree, folder, options.jobs)
        if trouble:
            print(f"{patch.stem}: does not build\n{trouble}", flush=True)
            return False
        kind, count, seen = see(expected_of(patch), folder, options)
    finally:
        git_apply(tree, patch, "--reverse")
    print(f"| {patch.stem} | {kind} | {count or 'MISSED'} |", flush=True)
    others = ", ".join(f"{it} {number}" for it, number in seen.items() if it != kind)
    if others:
        print(f"    beside it: {others}", file=sys.stderr, flush=True)
    return bool(count)


def check(patches):
    """Do all of them apply?"""
    if shutil.which("git") is None:
        print("there is no git, which applies them")
        return SKIPPED
    known = "".join(file.read_text(encoding="utf-8") for file in sorted((ROOT / "tests/soak").glob("*.cpp")))
    good = True
    for patch in patches:
        applied = git_apply(ROOT, patch, "--check")
        if applied.returncode != 0:
            print(f"{patch.stem}: does not apply any more\n{applied.stdout}")
            good = False
        elif expected_of(patch) != "any" and f'"{expected_of(patch)}"' not in known:
            print(f"{patch.stem}: the soak knows no violation {expected_of(patch)}")
    print(f"{len(patches)} patches: {'all apply' if good else 'not all apply'}")
    return 0 if good else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="only say whether the patches apply")
    parser.add_argument("--build", type=pathlib.Path, help="keeps copy and build here")
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--transactions", type=int, default=500)
    parser.add_argument("--jobs", type=int, help="of the compiler at a time")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    patches = sorted(HERE.glob("*.patch"))
    unknown = set(options.names) - {patch.stem for patch in patches}
    if unknown:
        parser.error(f"no such patch: {', '.join(sorted(unknown))}")
    patches = [patch for patch in patches if not options.names or patch.stem in options.names]
    if options.check:
        return check(patches)
    work = (options.build or pathlib.Path(tempfile.mkdtemp(prefix="mbgate-mutations-"))).resolve()
    tree = work / "tree"
    folder = tree / "build/mutation"  # as deep as the builds of the presets, so that ccache knows their objects
    synchronize(tree)
    trouble = build(tree, folder, options.jobs)
    if trouble:
        sys.exit(f"the copy does not build\n{trouble}")
    unbroken, _ = violations(folder, 1, options)
    if unbroken:
        print(f"WARNING: without any patch there is already {unbroken}", flush=True)
    print(f"| patch | violation | seen in seeds 1 to {options.seeds}, {options.transactions} transactions each |\n|---|---|---|",
          flush=True)
    missed = sum(not try_patch(patch, tree, folder, options) for patch in patches)
    if options.build is None:
        shutil.rmtree(work)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
