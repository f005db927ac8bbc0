#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""docs/threat-model.md: the tests that it names are there, and each way in has something that shows what stops it."""

import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).parents[2]
PAGE = ROOT / "docs/threat-model.md"
CASE = re.compile(r"^TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", re.MULTILINE)


def cpp_tests():
    sources = (path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*_test.cpp"))
    return {f"{suite}.{fact}" for text in sources for suite, fact in CASE.findall(text)}


def python_tests():
    found = set()
    for path in (ROOT / "tests").rglob("*_test.py"):
        text = path.read_text(encoding="utf-8")
        found |= {f"{path.name}: {name}" for name in re.findall(r"^    def (test_\w+)\(", text, re.MULTILINE)}
    return found


def ctest_names():
    text = (ROOT / "tests/CMakeLists.txt").read_text(encoding="utf-8")
    seeds = re.search(r"foreach\(first ([\d ]+)\)\n *add_test\(NAME judge.slice_", text).group(1).split()
    return {*(f"judge.slice_{first}" for first in seeds), *re.findall(r"add_test\(NAME (explore\.\w+)", text)}


def fuzzers():
    text = (ROOT / "tests/CMakeLists.txt").read_text(encoding="utf-8")
    return set(re.search(r"set\(fuzz_targets ([\w ]+)\)", text).group(1).split())


def missing(text):
    """What the page names and is not there."""
    known = cpp_tests() | python_tests() | ctest_names()
    named = re.findall(r"`([A-Z]\w+\.[A-Z0-9]\w+|\w+_test\.py: \w+|(?:judge|explore)\.\w+)`", text)
    absent = [name for name in named if name not in known]
    for words in re.findall(r"the fuzzers? ((?:\w+, )*\w+(?: and \w+)?)", text):
        absent += [name for name in re.split(r", | and ", words) if name not in fuzzers()]
    paths = re.findall(r"\btests/[\w./-]*\w", text)
    return absent + [path for path in paths if not (ROOT / path).exists()]


class ThreatModel(unittest.TestCase):
    def setUp(self):
        self.text = PAGE.read_text(encoding="utf-8")

    def test_every_test_is_there(self):
        self.assertEqual(missing(self.text), [])

    def test_a_test_that_is_not_there_is_seen(self):
        self.assertEqual(missing("`Gateway.DoesNothingLikeThis`, the fuzzers mbap and nothing; tests/none.py"),
                         ["Gateway.DoesNothingLikeThis", "nothing", "tests/none.py"])

    def test_each_way_in_has_something_that_shows_it(self):
        rows = [line for line in self.text.splitlines() if line.startswith("| ") and line.count("|") == 4]
        rows = [row.split("|") for row in rows if not row.startswith("| somebody")]
        self.assertGreater(len(rows), 20)
        for row in rows:
            self.assertRegex(row[3], r"`|tests/|the fuzzer", row[1])


if __name__ == "__main__":
    unittest.main()
