#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes hundreds of small errors in a copy of the product, all in one set of programs, and tells which no test sees.

usage: mutate.py [--count N] [--seed S] [--only FILE]... [--equivalent FILE] [--build FOLDER] [--jobs N]
                 [--unit NAME,...] [--soak NAME] [--soak-arguments "..."]... [--survivors] [--list | --show N]

mutators.py finds the places in the bus, the gateway, routing and modbus where a statement can be left out, a condition
negated, an integer shifted by one, two arguments exchanged, or a function left at once. Their order is drawn by --seed:
as many of each kind, and of each folder as it is long. The first --count that compile are the set. Each of them is in
the programs behind a number, and the environment variable MBGATE_MUTANT switches it on. A run without any tells which
test cases reach which (MBGATE_MUTANTS_REACHED); then these cases and the soak are run for each, until one sees it.
A process that dies, or needs ten times the processor time that it needs without it, has seen it too. What --equivalent
lists was found to mean the same by somebody who looked at it (equivalent.txt says how it is written), and is not run.

--list tells the first of the order, --show N how mutant N reads; both build nothing. In a folder that --build names the
copy and the build are kept.
"""

import argparse
import collections
import concurrent.futures
import difflib
import functools
import math
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import mutators
import run

HERE = pathlib.Path(__file__).resolve().parent
ROOT = run.ROOT
FOLDERS = ("bus", "gateway", "routing", "modbus")
UNIT = "modbus_tests,routing_tests,bus_tests,gateway_tests,simulation_tests"
# A few seeds first: what hangs does so in these, and is not waited for ten times as long as all take.
SOAK = ["--seed 1 --seeds 20 --transactions 500", "--seed 21 --seeds 480 --transactions 500"]
LONGER = 10  # what takes so many times as long as without a mutant does not end
SHORTEST = 5.0  # but nothing is given up before so many seconds
STANDS_STILL = 20  # times the limit, by the clock: a busy machine is not the mutant's fault
HOW = ["-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS_DEBUG=-O2 -g0 -w", "-DCMAKE_UNITY_BUILD=ON",
       *(["-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=mold"] if shutil.which("mold") else [])]


def failed_tests(text):
    return set(re.findall(r"^\[  FAILED  \] ([\w/]+\.[\w/]+)", text, re.MULTILINE))


def is_wanted(file):
    return file.startswith(tuple(f"src/{it}/" for it in FOLDERS)) and not mutators.LEFT_OUT.search(file)


def unit_of(folder, root):
    """The sources of a folder of src/ as one, and the compiler's options for it."""
    sources = sorted(it for it in (root / "src" / folder).rglob("*.cpp") if it.name != "main.cpp")
    text = "".join(f'#include "{it}"\n' for it in sources)
    return text, ["-std=c++20", f"-I{root}/src", '-DMBGATE_VERSION="0"', "-ferror-limit=0", "-Wno-narrowing"]


def places_in(folder):
    text, arguments = unit_of(folder, ROOT)
    return mutators.places(text, ROOT, is_wanted, arguments)


def errors_of(root, folder):
    return mutators.errors_in(mutators.read(*unit_of(folder, root)))


def in_order(places, seed):
    """All of them: the first of any number are spread evenly over the mutators and by length over the folders."""
    chance = random.Random(seed)
    by_span = collections.defaultdict(list)
    for it in sorted(set(places), key=str):
        by_span[it.file, it.start, it.end, it.mutator].append(it)
    decks = collections.defaultdict(list)
    for alike in by_span.values():
        decks[alike[0].mutator, folder_of(alike[0])].append(chance.choice(alike))
    lengths = collections.Counter()
    for file in {it.file for it in places}:
        lengths[file.split("/")[1]] += (ROOT / file).read_bytes().count(b"\n")
    ranked = []
    for (mutator, folder), deck in sorted(decks.items()):
        chance.shuffle(deck)
        ranked += [((rank + chance.random()) / lengths[folder], mutator, it) for rank, it in enumerate(deck)]
    return [it for _, _, it in sorted(ranked, key=lambda entry: entry[:2])]


def folder_of(mutant):
    return mutant.file.split("/")[1]


@functools.cache
def source_of(file):
    return mutators.Source((ROOT / file).read_bytes())


def lines_in(mutant):
    """The first and the last one."""
    return tuple(source_of(mutant.file).line_of(at) for at in (mutant.start, mutant.end))


def place_of(mutant):
    return f"{mutant.file}:{lines_in(mutant)[0]}"


def texts_of(mutant, begin=0, end=None):
    """The file, or a part of it, as it is, and as it becomes."""
    source = source_of(mutant.file)
    before, after = source.piece(begin, mutant.start), source.piece(mutant.end, end)
    return before + source.piece(mutant.start, mutant.end) + after, before + source.plain(mutant) + after


def lines_of(mutant):
    """The lines of the mutant as they are, and as they become; each as one."""
    text = source_of(mutant.file).text
    part = texts_of(mutant, text.rfind(b"\n", 0, mutant.start) + 1, text.find(b"\n", mutant.end))
    return tuple(" ".join(it.split()) for it in part)


def diff_of(mutant):
    before, after = (it.splitlines(True) for it in texts_of(mutant))
    return "".join(difflib.unified_diff(before, after, f"a/{mutant.file}", f"b/{mutant.file}"))


def equivalents_in(text):
    """Reasons by file, mutator, lines before and lines after."""
    reasons = {}
    stanzas = "\n".join(line for line in text.splitlines() if not line.startswith("#"))
    for stanza in re.split(r"\n\s*\n", stanzas.strip()) if stanzas.strip() else []:
        head, before, after, *reason = [line.strip() for line in stanza.splitlines()]
        reasons[*head.split(), before, after] = " ".join(reason)
    return reasons


class Build:
    """A copy of the tree with the mutants in it, and its programs."""

    def __init__(self, work, options):
        self.tree = work / "tree"
        self.folder = self.tree / "build/mutants"  # as deep as the builds of the presets
        self.options = options

    def write(self, mutants):
        """Makes the tree what it must be. What is the same keeps its time."""
        wanted = run.files_of(ROOT)
        for name in run.files_of(self.tree).keys() - wanted.keys():
            (self.tree / name).unlink()
        wanted[pathlib.Path("src") / mutators.HEADER.name] = mutators.HEADER.read_bytes()
        for file in {it.file for it in mutants.values()}:
            numbered = [(number, it) for number, it in mutants.items() if it.file == file]
            wanted[pathlib.Path(file)] = source_of(file).switched(numbered).encode()
        for name, content in wanted.items():
            path = self.tree / name
            if not path.exists() or path.read_bytes() != content:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)

    def compile(self):
        """Nothing, or what the compiler has to say."""
        if not (self.folder / "build.ninja").exists():
            launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
            made = run.run(["cmake", "-S", self.tree, "-B", self.folder, "-G", "Ninja", *HOW, *launcher])
            if made.returncode != 0:
                sys.exit(f"cmake does not take the copy\n{made.stdout}")
        targets = [it for it in (*self.options.unit, self.options.soak) if it]
        made = run.run(["ninja", "-k", "0", "-C", self.folder, "-j", str(self.options.jobs), *targets])
        return made.stdout if made.returncode != 0 else ""

    def understood(self):
        """The same by libclang, which compiles nothing: most of what is wrong is found sooner."""
        with concurrent.futures.ProcessPoolExecutor(self.options.jobs) as pool:
            return "".join(pool.map(functools.partial(errors_of, self.tree), FOLDERS))

    def refused(self, text, mutants):
        """The numbers of the mutants that stand where the compiler found errors, or in what led it there."""
        places = collections.defaultdict(set)
        for number, it in mutants.items():
            first, last = lines_in(it)
            for line in range(first, last + 1):
                places[it.file, line].add(number)
        numbers, led = set(), set()
        for file, line, kind in re.findall(r"^(?:In file included from )?(\S+?):(\d+):\S*\s+(.*)$", text, re.MULTILINE):
            path = os.path.relpath(self.folder / file, self.tree)
            here = places.get((path, int(line)), set())
            if "required from" in kind:
                led |= here
            elif kind.startswith("error:"):
                numbers |= here or led
                led = set()
        return numbers

    def make(self, order):
        """Programs with the first so many of the order that compile."""
        count, gone, size = self.options.count, set(), 0
        while True:
            enough = count - (size - len(gone))
            size = min(len(order), size + enough + enough // 8 + 2 if enough > 0 else size)
            mutants = {number: order[number] for number in range(size) if number not in gone}
            self.write(mutants)
            text = self.understood() or self.compile()
            if not text and (len(mutants) >= count or size == len(order)):
                return dict(list(mutants.items())[:count]), gone
            refused = self.refused(text, mutants)
            if text and not refused:
                sys.exit(f"the copy does not build\n{text[-4000:]}")
            gone |= refused
            print(f"{len(mutants)} mutants compiled, {len(refused)} of them do not", file=sys.stderr, flush=True)

    def program(self, name):
        return str(self.folder / "bin" / name)


def execute(command, limit, number=None, reached=None, stop=None):
    """What it wrote, its status, and the seconds of processor time that it took; nothing as the status if these were
    more than the limit, or it stood still. It is ended at the first line that stop matches."""
    seconds = math.ceil(limit)
    limits = ["prlimit", f"--as={run.MOST_MEMORY}", "--core=0", f"--cpu={seconds}:{seconds + 5}"]
    limits = limits if shutil.which("prlimit") else []
    surroundings = os.environ | ({"MBGATE_MUTANT": str(number)} if number is not None else {})
    surroundings |= {"MBGATE_MUTANTS_REACHED": str(reached)} if reached else {}
    late = threading.Event()
    with subprocess.Popen([*limits, *command], text=True, errors="replace", env=surroundings, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT) as process:
        end = functools.partial(os.kill, process.pid, signal.SIGKILL)  # Popen.kill() might wait for it, too
        timer = threading.Timer(STANDS_STILL * limit, lambda: (late.set(), end()))
        timer.start()
        lines = []
        for line in process.stdout:
            lines = [*lines[-200:], line]
            if stop and stop.search(line):
                end()
                break
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        timer.cancel()
    is_late = late.is_set() or process.returncode in (-signal.SIGXCPU, 128 + signal.SIGXCPU)
    return "".join(lines), None if is_late else process.returncode, usage.ru_utime + usage.ru_stime


def numbers_in(file):
    return {int(it) for it in file.read_text(encoding="ascii").split()} if file.exists() else set()


class Unit:
    """The unit tests: which cases there are, which mutants each reaches, and how long all of a program take."""

    def __init__(self, build, work, options):
        self.build, self.work, self.options = build, work, options
        self.cases = collections.defaultdict(lambda: collections.defaultdict(list))  # mutant -> program -> names
        self.seconds = {}
        self.failing = []
        work.mkdir(exist_ok=True)

    def look(self):
        for program in self.options.unit:
            self.seconds[program] = execute([self.build.program(program)], 3600)[2]
        with concurrent.futures.ThreadPoolExecutor(self.options.jobs) as pool:
            every = [(program, case) for program in self.options.unit for case in self.names_in(program)]
            list(pool.map(lambda it: self.look_at(*it), every))

    def names_in(self, program):
        suite, names = "", []
        for line in run.run([self.build.program(program), "--gtest_list_tests"]).stdout.splitlines():
            name = line.split("#")[0].rstrip()
            if name.startswith("  "):
                names.append(suite + name.strip())
            elif name.endswith("."):
                suite = name
        return names

    def look_at(self, program, case):
        reached = self.work / f"{program}-{case.replace('/', '-')}"
        reached.unlink(missing_ok=True)
        _, status, _ = execute([self.build.program(program), f"--gtest_filter={case}"], 600, reached=reached)
        if status != 0:
            self.failing.append(case)
            return
        for number in numbers_in(reached):
            self.cases[number][program].append(case)

    def try_mutant(self, number, mutant):
        """The first case that fails, what became of it, or None; "-" if none reaches it."""
        programs = self.cases.get(number)
        if not programs:
            return "-"
        for program in sorted(programs, key=lambda it: (it != f"{folder_of(mutant)}_tests", it)):
            flags = self.work / f"{number}-{program}.flags"
            flags.write_text(f"--gtest_filter={':'.join(programs[program])}\n--gtest_fail_fast\n", encoding="utf-8")
            limit = max(SHORTEST, LONGER * self.seconds[program])
            text, status, _ = execute([self.build.program(program), f"--gtest_flagfile={flags}"], limit, number)
            flags.unlink()
            if status != 0:
                running = re.findall(r"^\[ RUN      \] (\S+)", text, re.MULTILINE)[-1:]
                return min(failed_tests(text), default=" ".join([*running, "hangs" if status is None else "dies"]))
        return None


class Soak:
    """The soak: the mutants that it reaches, and the first violation of one."""

    SEEN = re.compile(r"^seed (\d+): (\w+)")

    def __init__(self, build, work, options):
        self.options, self.command = options, [build.program(options.soak)]
        self.reached, self.seconds = [], []
        for number, arguments in enumerate(options.soak_arguments):
            file = work / f"soak-{number}"
            file.unlink(missing_ok=True)
            text, status, seconds = execute(self.command + arguments.split(), 36000, reached=file)
            self.seconds.append(seconds)
            if status != 0:
                print(f"WARNING: without any mutant the soak already tells\n{text[-2000:]}", flush=True)
            self.reached.append(numbers_in(file))

    def try_mutant(self, number):
        if not any(number in reached for reached in self.reached):
            return "-"
        for arguments, reached, seconds in zip(self.options.soak_arguments, self.reached, self.seconds):
            if number not in reached:
                continue
            limit = max(SHORTEST, LONGER * seconds)
            text, status, _ = execute(self.command + arguments.split(), limit, number, stop=self.SEEN)
            seen = self.SEEN.search(text.splitlines()[-1]) if text else None
            if status is None:
                return "hangs"
            if status != 0:
                return f"{seen[2]} ({seen[1]})" if seen else "broken_invariant" if run.BROKEN.search(text) else "dies"
        return None


def row_of(number, mutant, unit, soak):
    broken = " → ".join(f"`{it}`" for it in lines_of(mutant)).replace("|", "\\|")
    seen = [{None: "NOT SEEN", "-": "not reached"}.get(it, it) for it in (unit, soak)]
    return f"| {' | '.join([str(number), place_of(mutant), mutant.mutator, broken, *seen])} |"


def try_all(mutants, unit, soak, options):
    """What each of both has seen of each mutant, printed as it comes."""
    lock = threading.Lock()

    def attempt(entry):
        number, mutant = entry
        by_unit = unit.try_mutant(number, mutant)
        is_seen = options.survivors and by_unit not in (None, "-")
        seen = (by_unit, soak.try_mutant(number) if soak and not is_seen else "-")
        with lock:
            print(row_of(number, mutant, *seen), flush=True)
        return number, seen

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        return dict(pool.map(attempt, mutants.items()))


def summary(mutants, results, equal):
    """Counts by mutator and by folder."""
    columns = ("unit alone", "soak alone", "both", "nobody", "of these not reached", "equal")
    counts = collections.defaultdict(collections.Counter)
    for number, mutant in mutants.items():
        for name in (mutant.mutator, folder_of(mutant), "all"):
            if number in equal:
                counts[name]["equal"] += 1
                continue
            unit, soak = (it not in (None, "-") for it in results[number])
            counts[name][{(True, True): "both", (True, False): "unit alone", (False, True): "soak alone"}.get(
                (unit, soak), "nobody")] += 1
            counts[name]["of these not reached"] += results[number] == ("-", "-")
    print(f"\n| | {' | '.join(columns)} |\n|{'---|' * (len(columns) + 1)}")
    for name in (*mutators.MUTATORS, *FOLDERS, "all"):
        if name in counts:
            print(f"| {name} | {' | '.join(str(counts[name][it]) for it in columns)} |")


def options_of():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", default=[], help="only mutants of this file; may be repeated")
    parser.add_argument("--equivalent", type=pathlib.Path, default=HERE / "equivalent.txt")
    parser.add_argument("--build", type=pathlib.Path, help="keeps copy and build here")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--unit", default=UNIT, type=lambda it: [name for name in it.split(",") if name])
    parser.add_argument("--soak", default="soak", help='the program; "" runs none')
    parser.add_argument("--soak-arguments", action="append", help="one run after the other, until one sees it")
    parser.add_argument("--survivors", action="store_true", help="the soak runs only for what no unit test sees")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--show", type=int)
    options = parser.parse_args()
    options.soak_arguments = options.soak_arguments or SOAK
    return options


def main():
    options = options_of()
    if mutators.cindex is None:
        print("libclang for Python is not installed (python3-clang-19)")
        return run.SKIPPED
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        places = [it for found in pool.map(places_in, FOLDERS) for it in found]
    only = {os.path.relpath(it, ROOT) for it in options.only}
    order = in_order([it for it in places if not only or it.file in only], options.seed)
    if options.show is not None:
        print(diff_of(order[options.show]), end="")
        return 0
    if options.list:
        for number, it in enumerate(order[:options.count]):
            print(f"{number}\t{place_of(it)}\t{it.mutator}\t{' -> '.join(lines_of(it))}")
        return 0
    work = (options.build or pathlib.Path(tempfile.mkdtemp(prefix="mbgate-mutants-"))).resolve()
    begun = time.monotonic()
    build = Build(work, options)
    mutants, gone = build.make(order)
    built = time.monotonic()
    reasons = equivalents_in(options.equivalent.read_text(encoding="utf-8")) if options.equivalent.exists() else {}
    equal = {number for number, it in mutants.items() if (it.file, it.mutator, *lines_of(it)) in reasons}
    unit = Unit(build, work / "reached", options)
    unit.look()
    if unit.failing:
        print(f"WARNING: without any mutant there already fail {' '.join(sorted(unit.failing))}", flush=True)
    soak = Soak(build, work / "reached", options) if options.soak else None
    looked = time.monotonic()
    print("| mutant | place | mutator | what is broken | unit tests | soak |\n|---|---|---|---|---|---|", flush=True)
    results = try_all({number: it for number, it in mutants.items() if number not in equal}, unit, soak, options)
    print("\nSeen by nobody:")
    for number, seen in sorted(results.items()):
        if all(it in (None, "-") for it in seen):
            print(row_of(number, mutants[number], *seen))
    summary(mutants, results, equal)
    print(f"\n{len(mutants)} of {len(order)} places, {len(gone)} more did not compile; building {built - begun:.0f} s, "
          f"unbroken runs {looked - built:.0f} s, mutants {time.monotonic() - looked:.0f} s")
    if options.build is None:
        shutil.rmtree(work)
    return 0


if __name__ == "__main__":
    sys.exit(main())
