#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the fuzzers with clang and runs each for some time, beginning with its corpus and with seeds.

usage: run.py [--seconds N] [--build FOLDER] [--findings FOLDER] [--merge] [TARGET...]

Exits 1 if there was a finding; its input is then in the findings' folder. --merge puts what reached something new
into tests/fuzz/corpus, as few inputs as reach the same; what once was a finding is kept there under a name of its own.
"""

import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import seeds

ROOT = pathlib.Path(__file__).resolve().parents[2]
CORPORA = ROOT / "tests/fuzz/corpus"
# Longest input of each target: enough for what it can do, short enough to be fast.
TARGETS = {"mbap": 1024, "role": 300, "rtu_framer": 1024, "ascii_framer": 1024, "plan": 600, "config": 6000, "profile": 6000,
           "machine": 1500, "plant": 2000, "rules": 2000, "http": 1500, "recording": 4000}
# Most inputs of a corpus: they are run again with every test.
MOST_INPUTS = 80
# Their names there: the beginning of a hash of their content.
FOUND_BY_FUZZER = re.compile("[0-9a-f]{16}")


def build(folder, targets):
    subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DCMAKE_CXX_COMPILER=clang++-19",
                    "-DMBGATE_FUZZ=ON", "-DCMAKE_COMPILE_WARNING_AS_ERROR=ON", "-DCMAKE_BUILD_TYPE=RelWithDebInfo",
                    "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1 -g1"],
                   check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", folder, *(f"fuzz_{target}" for target in targets)], check=True)


def dictionary(folder):
    """The words of our configuration files, for the targets that read text."""
    words = set()
    for file in [*ROOT.glob("conf/**/*.toml"), *ROOT.glob("tests/config/valid/*.toml")]:
        text = file.read_text(encoding="utf-8")
        words.update(re.findall(r"^#? ?([a-z0-9_]+) = ", text, re.MULTILINE))
        words.update(re.findall(r"^\[+([a-z_.]+)\]+", text, re.MULTILINE))
        words.update(word for word in re.findall(r'"([^"\n\\]{1,20})"', text) if word.isascii())
    file = folder / "words.dict"
    file.write_text("".join(f'"{word}"\n' for word in sorted(words)), encoding="ascii")
    return file


def fuzz(fuzzer, target, folder, options):
    """Runs one fuzzer; true if it found nothing."""
    found = folder / target
    found.mkdir()
    (CORPORA / target).mkdir(parents=True, exist_ok=True)
    seeds.write(target, found)
    command = [fuzzer, found, CORPORA / target, f"-max_len={TARGETS[target]}", f"-max_total_time={options.seconds}",
               "-timeout=60", "-print_final_stats=1", f"-artifact_prefix={options.findings}/{target}-"]
    if target in ("config", "profile", "rules", "recording"):
        command.append(f"-dict={dictionary(folder)}")
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, errors="replace")
    runs = re.search(r"number_of_executed_units: (\d+)", done.stderr)
    print(f"{target}: {'nothing found' if done.returncode == 0 else 'FINDING'} in {options.seconds} s,"
          f" {runs.group(1) if runs else '?'} runs", flush=True)
    if done.returncode != 0:
        print("\n".join(done.stderr.splitlines()[-60:]), flush=True)
    return done.returncode == 0


def merge(fuzzer, target, folder):
    """As few inputs as cover the same, in place of the corpus; inputs that have a name of their own are tests and stay."""
    merged = folder / f"{target}-merged"
    merged.mkdir()
    corpus = CORPORA / target
    named = {file.read_bytes() for file in corpus.iterdir() if not FOUND_BY_FUZZER.fullmatch(file.name)}
    subprocess.run([str(part) for part in (fuzzer, "-set_cover_merge=1", f"-max_len={TARGETS[target]}", merged, corpus,
                                           folder / target)], check=True, capture_output=True)
    chosen = [file for file in sorted(merged.iterdir(), key=lambda file: file.stat().st_mtime_ns)
              if file.read_bytes() not in named][:MOST_INPUTS]
    for file in corpus.iterdir():
        if FOUND_BY_FUZZER.fullmatch(file.name):
            file.unlink()
    for file in chosen:
        shutil.copyfile(file, corpus / file.name[:16])
    print(f"{target}: {len(chosen)} inputs, {sum(file.stat().st_size for file in chosen)} bytes, and {len(named)} that"
          " have a name", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=int, default=120)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/fuzz")
    parser.add_argument("--findings", type=pathlib.Path, default=ROOT / "build/fuzz/findings")
    parser.add_argument("--merge", action="store_true")
    parser.add_argument("targets", nargs="*", metavar="TARGET")
    options = parser.parse_args()
    unknown = set(options.targets) - set(TARGETS)
    if unknown:
        parser.error(f"no such target: {', '.join(sorted(unknown))}; there are {', '.join(TARGETS)}")
    targets = options.targets or list(TARGETS)
    build(options.build, targets)
    options.findings.mkdir(parents=True, exist_ok=True)
    good = True
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for target in targets:
            fuzzer = options.build / "bin" / f"fuzz_{target}"
            good = fuzz(fuzzer, target, folder, options) and good
            if options.merge:
                merge(fuzzer, target, folder)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
