#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A warning is an error in developers' builds alone: another compiler warns of other things, and must still build."""

import json
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]


def compile_commands(*arguments):
    """What the compiler is called with for our sources in a build that is configured so."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["cmake", "-G", "Ninja", "-B", folder, *arguments], cwd=ROOT, check=True,
                       stdout=subprocess.DEVNULL)
        commands = json.loads((pathlib.Path(folder) / "compile_commands.json").read_text(encoding="utf-8"))
    return [entry["command"] for entry in commands]


class Warnings(unittest.TestCase):
    def test_are_no_errors_in_a_plain_build(self):
        commands = compile_commands("-S", ROOT, "-DCMAKE_BUILD_TYPE=Release")
        self.assertTrue(any("tests/unit/sim" in command for command in commands))
        self.assertEqual([], [command for command in commands if "-Werror" in command])

    def test_are_no_errors_in_what_users_run(self):
        self.assertEqual([], [command for command in compile_commands("--preset", "release") if "-Werror" in command])

    def test_are_errors_in_what_we_test(self):
        commands = compile_commands("--preset", "asan")
        self.assertTrue(commands)
        self.assertEqual([], [command for command in commands if "-Werror" not in command])


if __name__ == "__main__":
    unittest.main()
