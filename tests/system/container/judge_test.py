#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What judges the restarts under load finds what must not be."""

import pathlib
import sys
import unittest
from types import SimpleNamespace

sys.path.insert(0, str(pathlib.Path(__file__).parent))

from checks_restart import longest_gap, seen_without_answer, writes  # noqa: E402
from drive import crc  # noqa: E402


def judged(seen, done=(), refused=(), unknown=(), lost=()):
    """What writes() and seen_without_answer() say of one client, and of what its drive has seen."""
    worker = SimpleNamespace(bus="line-a", unit=1, register=7, done=list(done), refused=list(refused),
                             unknown=list(unknown), lost=list(lost))
    lines = {"line-a": SimpleNamespace(writes={(1, 7): list(seen)})}
    return writes([worker], lines)[1], seen_without_answer([worker], lines)


class Judge(unittest.TestCase):
    def test_is_content_with_what_may_be(self):
        self.assertEqual(judged([1, 3, 4], done=[1, 4], refused=[2], unknown=[3], lost=[5]), ([], 1))

    def test_finds_a_write_that_was_seen_twice(self):
        self.assertEqual(judged([1, 2, 2], done=[1, 2])[0], ["register 7: a value twice or out of order"])

    def test_finds_an_old_write_behind_a_newer_one(self):
        self.assertEqual(judged([2, 1], done=[2], lost=[1])[0], ["register 7: a value twice or out of order"])

    def test_finds_a_write_that_was_answered_and_not_sent(self):
        self.assertEqual(judged([1], done=[1, 2])[0], ["register 7: 2 was answered and not seen"])

    def test_finds_a_write_that_was_refused_and_sent(self):
        self.assertEqual(judged([1, 2], done=[1], refused=[2])[0], ["register 7: 2 was refused and seen"])

    def test_finds_a_write_that_nobody_asked_for(self):
        self.assertEqual(judged([1, 2], done=[1])[0], ["register 7: 2 was never written"])

    def test_measures_the_longest_time_without_an_answer(self):
        self.assertEqual(longest_gap([9.5, 10.0, 10.25, 12.25, 12.5], 10.1, 20), 2.0)

    def test_takes_a_restart_after_which_nobody_is_served_for_the_whole_time(self):
        self.assertEqual(longest_gap([9.5, 10.0], 10.5, 20.5), 10.0)


class Drive(unittest.TestCase):
    def test_has_the_crc_of_the_standard(self):
        self.assertEqual(crc(bytes.fromhex("0207")), bytes.fromhex("4112"))


if __name__ == "__main__":
    unittest.main()
