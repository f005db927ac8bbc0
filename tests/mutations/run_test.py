#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What is read out of a soak's words: which violation, in which seed first, and that it died."""

import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import run  # noqa: E402

TWO_SEEDS = """seed 4: silence: 2 us too early
seed 4: silence: 3 us too early
seed 4: quarantine: too early
replay: soak --seed 4 --transactions 500
seed 7: misdelivered: not what was asked
100 seeds, 2 with violations: 50000 transactions
  violations: misdelivered 9 quarantine 1 silence 12
  1.0 s, 50000 transactions a second
"""
NOTHING = "100 seeds, 0 with violations: 50000 transactions\n  faults: noise 3\n  1.0 s\n"
DEAD = "seed 3: no_progress: the gateway's deadline stays in the past\nSegmentation fault\n"

BROKEN = "seed 2: silence: 2 us too early\nbroken invariant: a write is transmitted once (src/bus/x.cpp:31)\n"
LIBRARY = "/usr/include/c++/12/span:380: subspan(size_type) const: Assertion '__offset <= size()' failed.\n"


class ASoakTells(unittest.TestCase):
    def test_how_often_each_violation_was_seen_and_in_which_seed_first(self):
        seen = run.seen_in(TWO_SEEDS)
        self.assertEqual(seen.counts, {"misdelivered": 9, "quarantine": 1, "silence": 12})
        self.assertEqual(seen.seeds, {"silence": 4, "quarantine": 4, "misdelivered": 7})
        self.assertFalse(seen.died)

    def test_nothing(self):
        self.assertEqual(run.seen_in(NOTHING), run.Seen({}, {}, False))

    def test_that_it_died_and_what_it_had_told(self):
        self.assertEqual(run.seen_in(DEAD), run.Seen({"no_progress": 1}, {"no_progress": 3}, True))
        self.assertEqual(run.seen_in(""), run.Seen({}, {}, True))

    def test_that_an_assertion_has_ended_it(self):
        self.assertEqual(run.seen_in(BROKEN), run.Seen({"silence": 1, "broken_invariant": 1}, {"silence": 2}, False))
        self.assertEqual(run.seen_in(LIBRARY), run.Seen({"broken_invariant": 1}, {}, False))


class APatchIsSeen(unittest.TestCase):
    def test_by_the_violation_that_it_names_alone(self):
        self.assertEqual(run.kind_of("quarantine", run.seen_in(TWO_SEEDS)), "quarantine")
        self.assertIsNone(run.kind_of("turnaround", run.seen_in(TWO_SEEDS)))

    def test_by_the_first_of_any(self):
        self.assertEqual(run.kind_of("any", run.seen_in(TWO_SEEDS)), "silence")
        self.assertIsNone(run.kind_of("any", run.seen_in(NOTHING)))

    def test_by_no_soak_that_only_died(self):
        self.assertIsNone(run.kind_of("any", run.seen_in("")))


class ACopy(unittest.TestCase):
    def test_has_all_that_the_build_includes(self):
        copied = run.files_of(run.ROOT)
        listed = (run.ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
        for included in re.findall(r"^include\((\S+\.cmake)\)", listed, re.MULTILINE):
            self.assertIn(pathlib.Path(included), copied)


if __name__ == "__main__":
    unittest.main()
