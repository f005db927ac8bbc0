#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""docs/recording.md: its recording can be replayed, and every command says what stands below it."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/recording.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
REPLAY = re.compile(r"^mbgatectl replay (\S+)$", re.MULTILINE)


def words(of):
    """The first words of the rows of the table with that heading, as a recording has them."""
    rows = re.search(rf"^\| {of} \|.*?\n\n", PAGE, re.MULTILINE | re.DOTALL)[0]
    return set(re.findall(r"`(?:< )?([a-z]+)", "\n".join(row.split(" | ")[0] for row in rows.splitlines())))


class Page(unittest.TestCase):
    def test_what_the_commands_say(self):
        recording = next(block for block in BLOCKS if block.startswith("mbgate recording"))
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "plant.rec").write_text(recording, encoding="utf-8")
            environment = os.environ | {"PATH": f"{os.environ['MBGATE_PROGRAMS']}:{os.environ['PATH']}"}
            replays = 0
            for block, said in zip(BLOCKS, BLOCKS[1:]):
                if REPLAY.search(block):
                    command = REPLAY.sub(rf"mbgatectl replay \1 --profiles {ROOT}/conf/profiles", block)
                    done = subprocess.run(command, shell=True, cwd=folder, env=environment, capture_output=True,
                                          text=True, timeout=60, check=False)
                    self.assertEqual(done.stdout + done.stderr, said, block)
                    replays += 1
            self.assertEqual(replays, 2)

    def test_the_tables_know_every_word(self):
        source = (ROOT / "src/report/recording/record.cpp").read_text(encoding="utf-8")
        for of, table in ("input", "kInputWords"), ("action", "kActionWords"):
            written = set(re.findall(r'"([a-z]+)"', re.search(rf"{table}\{{(.*?)\}};", source, re.DOTALL)[1]))
            self.assertGreater(len(written), 5, of)
            self.assertEqual(written - words(of), set(), of)


if __name__ == "__main__":
    unittest.main()
