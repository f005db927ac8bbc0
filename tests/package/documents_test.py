#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The documents of the package, put together by debhelper without the programs, under debian/tests/documents."""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
SKIPPED = 77
# Nothing else: within a build of the package, debhelper's own variables are set.
SURROUNDINGS = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL": "C.UTF-8"}
SOURCES = ("bench", "conf", "debian", "docs", "examples", "systemd", "CHANGELOG.md", "LICENSE", "README.md",
           "SECURITY.md")


def make_documents(folder):
    for name in SOURCES:
        source = ROOT / name
        (shutil.copytree if source.is_dir() else shutil.copy)(source, folder / name)
    package = folder / "debian/mbgate"
    shutil.copytree(ROOT / "conf/profiles", package / "usr/share/mbgate/profiles")  # as `cmake --install` does
    steps = (["dh_install"], ["debian/rules", "execute_after_dh_install"], ["dh_installdocs"], ["dh_installexamples"],
             ["debian/rules", "execute_after_dh_installdocs"])
    for command in steps:
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, env=SURROUNDINGS)
    return package


def look_at(package):
    return subprocess.run([ROOT / "debian/tests/documents"], check=False, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, env=SURROUNDINGS | {"MBGATE_ROOT": str(package)})


class Documents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.package = make_documents(pathlib.Path(folder.name))
        cls.readme = cls.package / "usr/share/doc/mbgate/README.md"

    def test_link_only_to_what_is_in_the_package(self):
        done = look_at(self.package)
        self.assertEqual(0, done.returncode, done.stdout)

    def test_still_link_to_what_is(self):
        for document, links in (("README.md", ("(mbgate.toml)", "(examples)", "(copyright)", "(bench/README.md)",
                                               "(docs/behaviour.md)")),
                                ("docs/installing.md", ("(../examples/demo.toml)", "(../README.md#two-drives-on-a-usb-adapter)")),
                                ("docs/drives.md", ("(../profiles/README.md)",)),
                                ("docs/status.md", ("(api.yaml)", "(screenshots/overview.png)"))):
            text = (self.readme.parent / document).read_text(encoding="utf-8")
            for link in links:
                self.assertIn(link, text)

    def test_a_link_to_nothing_is_seen(self):
        text = self.readme.read_text(encoding="utf-8")
        self.addCleanup(self.readme.write_text, text, encoding="utf-8")
        self.readme.write_text(text + "[nothing](src/README.md) [no heading](docs/tls.md#nothing)\n", encoding="utf-8")
        done = look_at(self.package)
        self.assertEqual(1, done.returncode)
        self.assertIn("README.md: src/README.md is not there\n", done.stdout)
        self.assertIn("README.md: docs/tls.md#nothing is not there\n", done.stdout)


if __name__ == "__main__":
    if shutil.which("dh_installdocs") is None:
        print("skipped: debhelper is not installed")
        sys.exit(SKIPPED)
    unittest.main()
