#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The package's scripts, made by debhelper without building the programs, under debian/tests/upgrade."""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
SKIPPED = 77
# Nothing else: within a build of the package, debhelper's own variables are set.
SURROUNDINGS = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}


def make_scripts(folder):
    """What dpkg-buildpackage would make of debian/ and systemd/; returns the package's root."""
    for part in ("debian", "systemd"):
        shutil.copytree(ROOT / part, folder / part)
    install = folder / "debian/mbgate.install"
    lines = install.read_text(encoding="utf-8").splitlines()
    ours = [line for line in lines if line.startswith(("systemd/", "debian/"))]
    install.write_text("\n".join(ours) + "\n", encoding="utf-8")
    for command in (["dh_install"], ["debian/rules", "override_dh_installsystemd"], ["dh_installdeb"]):
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, env=SURROUNDINGS)
    return folder / "debian/mbgate"


class Upgrade(unittest.TestCase):
    def test_leaves_the_gateway_running(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            package = make_scripts(folder)
            work = folder / "work"
            work.mkdir()
            done = subprocess.run([ROOT / "debian/tests/upgrade"], check=False, text=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT,
                                  env=SURROUNDINGS | {"MBGATE_ROOT": str(package), "AUTOPKGTEST_TMP": str(work)})
            self.assertEqual(0, done.returncode, done.stdout)


if __name__ == "__main__":
    if shutil.which("dh_installsystemd") is None:
        print("skipped: debhelper is not installed")
        sys.exit(SKIPPED)
    unittest.main()
