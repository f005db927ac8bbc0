#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Keeps the arrows between the modules of src/ (see src/README.md) and a few rules that a compiler does not know.

Every header is visible to every target, so nothing else stops a module from including what it must not know.
usage: arrows.py [FOLDER], FOLDER holding src/, tests/ and bench/.
"""

import pathlib
import re
import sys

sys.dont_write_bytecode = True

import fronts  # noqa: E402  (nothing is written beside it)

# Who may include whom; what a module's headers show of the modules below is within its reach.
BASE = {"base"}
MODBUS = BASE | {"modbus"}
DRIVE = MODBUS | {"drive"}
ROUTING = DRIVE | {"routing"}
BUS = DRIVE | {"bus"}
GATEWAY = ROUTING | BUS | {"gateway"}
SYS = BASE | {"sys"}
REPORT = GATEWAY | {"report"}
IO = REPORT | SYS | {"io"}
CONFIG = DRIVE | {"config"}
MODULES = {
    "base": BASE,
    "sys": SYS,
    "modbus": MODBUS,
    "drive": DRIVE,
    "routing": ROUTING,
    "bus": BUS,
    "gateway": GATEWAY,
    "report": REPORT,
    "config": CONFIG,
    "io": IO,
    "signer": SYS | {"signer"},
    "app": IO | CONFIG | {"app"},
    "sim": CONFIG | SYS | {"sim"},
    "ctl": CONFIG | SYS | {"ctl"},
}
# Folders that see more than the rest of their module: a replay runs the machine itself; a role in a certificate is
# shown as a gateway reads it.
FOLDERS = {
    "ctl/replay": REPORT | CONFIG | SYS | {"ctl"},
    "ctl/tls": ROUTING | CONFIG | SYS | {"ctl"},
}
# Single headers beyond a module's arrows: plain data that carries no decision, and where units lead.
SETTINGS = {"gateway/settings.hpp", "gateway/limits.hpp", "routing/route.hpp", "routing/client_address.hpp",
            "bus/settings.hpp", "routing/route_table.hpp"}
EXTRA_HEADERS = {
    "config": SETTINGS,
    "sim": {"bus/instant.hpp"},
}
# The modules that tests of several modules see. Integration tests know only the built programs.
TEST_FOLDERS = {
    "simulation": REPORT | CONFIG | {"sim"},
    "drives": REPORT | CONFIG | {"sim"},
    "world": GATEWAY,
    "judge": REPORT,
    "explore": GATEWAY,
    "fuzz": IO | CONFIG | {"app", "ctl"},
    "integration": set(),
    "support": REPORT | CONFIG | {"sim"},
    "manuals": MODBUS,
}
# The harness is no part of the gateway, nor does it know it: CRCs and ptys, and the machine for what is timed alone.
BENCH = GATEWAY | SYS | {"sim"}
# What it shares with the tests: one loop that takes the machine's actions.
BENCH_TESTS = {"support/gateway_harness.hpp"}

PURE_MODULES = {"modbus", "drive", "routing", "bus", "gateway", "report"}
PURE_LIBRARIES = ("boost/container/", "boost/intrusive/", "boost/system/", "fmt/")
# A pure module has no clock of its own, no thread, no socket, no file and no terminal.
IMPURE_STANDARD = {
    "atomic", "barrier", "condition_variable", "coroutine", "ctime", "filesystem", "fstream", "future", "iostream",
    "latch", "mutex", "random", "semaphore", "shared_mutex", "stop_token", "thread",
}
PURE_EXCEPTIONS = {("src/routing/client_address.cpp", "arpa/inet.h")}  # text to address, no socket
IMPURE_WORDS = re.compile(r"_clock::now\b|\bclock_gettime\b|\bgetenv\b|\bstd::rand\b|\bshared_ptr\b")

# Libraries that only some files may see: a pattern of includes, and a pattern of the files.
LIBRARIES = (
    (r"boost/asio", r"src/(io|app)/|src/(sim|ctl)/(main|shell|.*_shell|pty.*)\.|tests/unit/(io|app)/|"
     r"tests/fuzz/http\.cpp"),
    (r"fmt/", r"tests/|src/(?!sys/|drive/|routing/|bus/|signer/)"),  # not where no text is made, nor beside private keys
    (r"toml\+\+", r"src/config/toml/toml_reader\."),
    (r"systemd/", r"src/app/(systemd|journal/journal)\."),
    (r"modbus/modbus\.h|modbus\.h", r"src/ctl/|tests/integration/"),
    (r"prometheus/", r"src/app/metrics/|tests/unit/app/metrics/"),
    (r"openssl/", r"src/(sys|io/(tls|uplink)|signer|ctl/tls)/|tests/unit/(sys|io/(tls|uplink)|signer)/|bench/tls\."),
    (r"n?curses|term\.h", r"src/ctl/control/screen_shell\."),
    (r"CLI/", r"src/(app|ctl|sim)/(command_line|main)\.|src/ctl/options/|bench/main\."),
    (r"gtest/|gmock/", r"tests/"),
)

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
SPDX = "SPDX-License-Identifier: Apache-2.0"
MOST_LINES = 300
# A folder with more units (a header, a source or both) is a warehouse, not a module.
MOST_UNITS = 20
# Lines of tests that are not unit tests, by folders.
PROOFS = {10_500: ("world", "judge"), 13_400: ("world", "judge", "simulation", "explore")}
MOST_SOURCE_LINES, MOST_SOURCES = 57_995, 469  # of src/: less when something goes, never more without a word in docs/decisions
MOST_PATCHES = 30
MOST_PAGE = 200


def reach_of_module(parts):
    """The modules that a file of a module, or of its tests, may include; `parts` is its path within src/ or tests/unit/."""
    return FOLDERS.get("/".join(parts[:2]), MODULES.get(parts[0]))


def modules_in_reach(path):
    """The modules that the file `path` may include."""
    parts = path.split("/")
    if parts[0] == "src":
        return reach_of_module(parts[1:])
    if parts[0] == "bench":
        return BENCH
    if parts[1] == "unit":
        return reach_of_module(parts[2:])
    return TEST_FOLDERS.get(parts[1])


def check_module(path, header):
    """An include of ours, "module/file.hpp": does an arrow lead there?"""
    module = header.split("/")[0]
    if "/" not in header:
        return []  # a file of the same folder
    parts = path.split("/")
    if module not in MODULES:
        if parts[0] == "tests" or (parts[0] == "bench" and header in BENCH_TESTS):
            return []
        return [f'{path}: includes "{header}", but no arrow leads from here to the tests']
    reach = modules_in_reach(path)
    if reach is None:
        return [f"{path}: stands in no module that tests/tidy/arrows.py knows"]
    own_module = parts[1] if parts[0] == "src" else parts[2] if parts[1] == "unit" else ""
    if module in reach or header in EXTRA_HEADERS.get(own_module, set()):
        return []
    return [f'{path}: includes "{header}", but no arrow leads from here to {module}/']


def check_libraries(path, header):
    found = []
    for pattern, files in LIBRARIES:
        if re.match(pattern, header) and not re.match(files, path):
            found.append(f"{path}: includes <{header}>, which belongs elsewhere ({files})")
    return found


def check_purity(path, header):
    """A system include in a pure module: only what has no outside."""
    if (path, header) in PURE_EXCEPTIONS or header.startswith(PURE_LIBRARIES):
        return []
    if "/" in header or header.endswith(".h") or header in IMPURE_STANDARD:
        return [f"{path}: includes <{header}>, but this module is pure"]
    return []


def check_source(path, text):
    """All findings about one C++ file; `path` is relative, with slashes."""
    found = []
    if not text.startswith(f"// {SPDX}\n"):
        found.append(f"{path}: the first line must be // {SPDX}")
    lines = text.count("\n")
    if lines > MOST_LINES:
        found.append(f"{path}: has {lines} lines, more than {MOST_LINES}")
    if path.endswith(".hpp") and "\n#pragma once\n" not in text:
        found.append(f"{path}: a header without #pragma once")
    pure = path.startswith("src/") and path.split("/")[1] in PURE_MODULES
    for bracket, header in INCLUDE.findall(text):
        if bracket == '"':
            found += check_module(path, header)
        found += check_libraries(path, header)
        if pure and bracket == "<":
            found += check_purity(path, header)
    if pure:
        for word in IMPURE_WORDS.findall(COMMENT.sub("", text)):
            found.append(f"{path}: says {word}, but this module is pure")
    return found


def check_script(path, text):
    """Scripts and CMake files: only the licence line, after a #! line if there is one."""
    head = text.split("\n")[:2]
    return [] if f"# {SPDX}" in head else [f"{path}: the first line (after #!) must be # {SPDX}"]


def check_crowding(root):
    """Folders of src/ with more units than a reader keeps in mind."""
    units = {}
    for file in (root / "src").rglob("*"):
        if file.suffix in (".cpp", ".hpp"):
            units.setdefault(file.parent.relative_to(root).as_posix(), set()).add(file.stem)
    return [
        f"{folder}: has {len(held)} units, more than {MOST_UNITS}"
        for folder, held in sorted(units.items())
        if len(held) > MOST_UNITS
    ]


def check_budgets(root):
    """What grows by itself: the proofs, until they are larger than what they prove, and the page about them."""
    sources = list((root / "src").rglob("*.?pp"))
    lines = sum(file.read_text(encoding="utf-8").count("\n") for file in sources)
    found = [f"src: has {have} {what}, more than {most}"
             for what, have, most in (("lines", lines, MOST_SOURCE_LINES), ("files", len(sources), MOST_SOURCES)) if have > most]
    for budget, folders in PROOFS.items():
        sources = [file for folder in folders for file in (root / "tests" / folder).rglob("*.?pp")]
        lines = sum(file.read_text(encoding="utf-8").count("\n") for file in sources)
        if lines > budget:
            found.append(f"tests/{{{','.join(folders)}}}: have {lines} lines, more than {budget}")
    patches = len(list((root / "tests/mutations").rglob("*.patch")))
    if patches > MOST_PATCHES:
        found.append(f"tests/mutations: has {patches} patches, more than {MOST_PATCHES}")
    for page in ("README.md", "tests/README.md", "src/README.md"):
        lines = (root / page).read_text(encoding="utf-8").count("\n") if (root / page).exists() else 0
        if lines > MOST_PAGE:
            found.append(f"{page}: has {lines} lines, more than {MOST_PAGE}")
    return found


def check_tree(root):
    """All findings about src/, tests/ and bench/ below `root`, and how many files were looked at."""
    found, files, includes = check_crowding(root) + check_budgets(root), 0, []
    for file in sorted(path for folder in ("src", "tests", "bench") for path in (root / folder).rglob("*") if path.is_file()):
        path = file.relative_to(root).as_posix()
        if file.suffix in (".cpp", ".hpp", ".h", ".cc"):
            files += 1
            if file.suffix not in (".cpp", ".hpp"):
                found.append(f"{path}: sources end in .cpp and .hpp")
            text = file.read_text(encoding="utf-8")
            includes += [(path, header) for bracket, header in INCLUDE.findall(text) if bracket == '"']
            found += check_source(path, text) + fronts.check_mirror(root, path)
        elif file.suffix in (".py", ".sh") or file.name == "CMakeLists.txt":
            files += 1
            found += check_script(path, file.read_text(encoding="utf-8"))
    return found + fronts.check(root, includes), files


def report(check, what):
    """Prints what `check` finds in the tree, and in how many of `what`; the exit status: 0 if nothing was found."""
    found, looked_at = check(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]))
    for finding in found:
        print(finding)
    print(f"{looked_at} {what}, {len(found)} findings")
    return 1 if found or looked_at == 0 else 0


def main():
    return report(check_tree, "files")


if __name__ == "__main__":
    sys.exit(main())
