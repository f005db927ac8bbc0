#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What `cmake --install` puts on a machine beside the programs. usage: install_test.py FOLDER-OF-THE-BUILD"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
BUILD = sys.argv.pop(1)


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        subprocess.run(["cmake", "--install", BUILD, "--component", "system"], check=True, stdout=subprocess.DEVNULL,
                       env=os.environ | {"DESTDIR": folder.name})
        cls.files = {path.name: path for path in pathlib.Path(folder.name).rglob("*") if path.is_file()}

    def test_has_every_unit_manual_page_completion_and_account(self):
        units = {path.name for path in (ROOT / "systemd").glob("*") if path.suffix in (".service", ".socket")}
        pages = {path.name for path in (ROOT / "debian/man").glob("*.[158]")}
        rest = {"mbgate.catalog", "mbgate.conf", "mbgate.toml", "mbgatectl", "_mbgated"}
        self.assertEqual(set(), (units | pages | rest) - self.files.keys())

    def test_units_start_the_programs_that_are_installed_with_them(self):
        cache = pathlib.Path(BUILD, "CMakeCache.txt").read_text(encoding="utf-8")
        prefix = re.search(r"^CMAKE_INSTALL_PREFIX:PATH=(.*)$", cache, re.MULTILINE).group(1)
        for unit, programs in (("mbgated.service", {"sbin/mbgated", "bin/mbgatectl"}),
                               ("mbgate-signer.service", {"sbin/mbgate-signer"})):
            text = self.files[unit].read_text(encoding="utf-8")
            named = set(re.findall(r"(?<=[= ])/\S+/(?:mbgated|mbgatectl|mbgate-signer)(?= |$)", text, re.MULTILINE))
            self.assertEqual({f"{prefix}/{program}" for program in programs}, named)

    def test_writes_no_configuration(self):
        self.assertEqual([], [path for path in self.files.values() if "etc" in path.parts])


if __name__ == "__main__":
    unittest.main()
