#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The journal's catalog: an entry for each MESSAGE_ID and no other, each as an operator needs it, and as systemd reads it."""

import collections
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).parents[2]
IDS_FILE = SOURCE / "src/app/journal/message_id.hpp"
CATALOG_FILE = SOURCE / "systemd/mbgate.catalog"
IDS = re.findall(r'MessageId (k\w+)\{"([^"]*)"\}', IDS_FILE.read_text(encoding="utf-8"))
FIELDS = {"MBGATE_BUS", "MBGATE_LISTENER", "MBGATE_CLIENT"}


def entries():
    """Of the catalog: ID, the head as lines, the text."""
    found = []
    for part in re.split(r"(?m)^-- ", CATALOG_FILE.read_text(encoding="utf-8"))[1:]:
        identifier, _, rest = part.partition("\n")
        head, _, text = rest.partition("\n\n")
        found.append((identifier, head.split("\n"), re.sub(r"(?m)^#.*\n", "", text).strip()))
    return found


class CatalogTest(unittest.TestCase):
    def test_every_id_is_a_random_one_of_its_own(self):
        self.assertGreater(len(IDS), 60)
        for name, identifier in IDS:
            self.assertRegex(identifier, r"^[0-9a-f]{12}4[0-9a-f]{3}[89ab][0-9a-f]{15}$", name)  # sd_id128_randomize(3)
        for values in zip(*IDS):
            self.assertEqual([value for value, count in collections.Counter(values).items() if count > 1], [])

    def test_every_id_is_written_by_something(self):
        files = [file for file in (SOURCE / "src/app").rglob("*.cpp")]
        used = set(re.findall(r"\bk\w+", "".join(file.read_text(encoding="utf-8") for file in files)))
        self.assertLessEqual({name for name, _ in IDS}, used)

    def test_every_id_has_an_entry_and_every_entry_an_id(self):
        self.assertEqual([identifier for identifier, _, _ in entries()], [identifier for _, identifier in IDS])

    def test_an_entry_says_what_happened_and_what_to_do(self):
        for identifier, head, text in entries():
            subject, *rest = head
            self.assertRegex(subject, r"^Subject: \S.{5,69}$", identifier)
            self.assertEqual(rest, ["Defined-By: mbgate", "Documentation: man:mbgated(8)"], identifier)
            self.assertGreaterEqual(text.count("\n\n"), 1, f"{identifier}: what it means, and what to do")
            self.assertEqual([line for line in text.split("\n") if len(line) > 100], [], identifier)

    def test_an_entry_uses_fields_that_mbgated_writes(self):
        for identifier, _, text in entries():
            self.assertLessEqual(set(re.findall("@([^@ ]*)@", text)), FIELDS, identifier)

    @unittest.skipUnless(shutil.which("journalctl"), "journalctl is not there")
    def test_systemd_reads_it_without_a_warning(self):
        with tempfile.TemporaryDirectory() as folder:
            installed = pathlib.Path(folder) / "usr/lib/systemd/catalog"
            installed.mkdir(parents=True)
            shutil.copy(CATALOG_FILE, installed)
            update = ["journalctl", "--update-catalog", f"--root={folder}"]
            read = subprocess.run(update, capture_output=True, text=True, check=False)
            self.assertEqual((read.returncode, read.stdout, read.stderr), (0, "", ""))
            known = subprocess.run(
                ["journalctl", "--list-catalog", f"--root={folder}"], capture_output=True, text=True, check=True
            )
            subjects = {identifier: head[0].removeprefix("Subject: ") for identifier, head, _ in entries()}
            listed = dict(re.findall(r"(?m)^(\w{32}) mbgate: (.*)$", known.stdout))
            self.assertEqual(listed, subjects)


if __name__ == "__main__":
    sys.exit(unittest.main())
