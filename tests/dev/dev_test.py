#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What ./dev does about missing packages, shown with an apt-get, a sudo and a dpkg-query that only take notes."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
NOBODY = 65534
# What ./dev uses of a fresh machine before anything is installed.
TOOLS = ("awk bash cat dirname dpkg env grep id kill mkdir mktemp nproc rm sed sleep sort tail tr").split()

NOTE = '#!/bin/bash\necho "${0##*/} $*" >>"$NOTES"\n'
# Knows every package but those in $MISSING, as a machine with Debian 12's versions does.
DPKG_QUERY = r"""#!/bin/bash
if [[ $* == *Provides* ]]; then
  [[ " $MISSING " == *" debhelper "* ]] || echo "installed, debhelper-compat (= 12), debhelper-compat (= 13),"
  exit
fi
name=${*: -1}
[[ $name == libboost-dev ]] && echo "installed 1.74.0.3" && exit
[[ $name == debhelper-compat || " $MISSING " == *" $name "* ]] && exit 1
echo "installed 99.0"
"""


class Machine:
    """A checkout with nothing in it but ./dev and debian/, and a PATH of our own making."""

    def __init__(self, test, sudo=True):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        test.addCleanup(shutil.rmtree, self.folder)
        self.notes = self.folder / "notes"
        self.notes.touch()
        self.tools = self.folder / "tools"
        self.tools.mkdir()
        for tool in TOOLS:
            (self.tools / tool).symlink_to(shutil.which(tool))
        self.add("dpkg-query", DPKG_QUERY)
        self.add("apt-get", NOTE + 'echo "frontend $DEBIAN_FRONTEND" >>"$NOTES"\nexit "${APT_STATUS:-0}"\n')
        self.add("cmake", "#!/bin/bash\nexit 1\n")  # the end of the way: all was there
        if sudo:
            self.add("sudo", NOTE + 'exec "$@"\n')
        shutil.copy(ROOT / "dev", self.folder)
        shutil.copytree(ROOT / "debian", self.folder / "debian")
        for path in (self.folder, *self.folder.rglob("*")):
            if not path.is_symlink():
                path.chmod(path.stat().st_mode | 0o777)

    def add(self, name, text):
        (self.tools / name).write_text(text, encoding="utf-8")
        (self.tools / name).chmod(0o755)

    def run(self, *arguments, root=False, **variables):
        """Exit status and output of ./dev, as root or as nobody."""
        user = {} if root or os.geteuid() != 0 else {"user": NOBODY, "group": NOBODY, "extra_groups": []}
        done = subprocess.run(
            [self.folder / "dev", *arguments],
            env={"PATH": str(self.tools), "NOTES": str(self.notes), "MISSING": "", **variables},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=60,
            check=False,
            **user,
        )
        return done.returncode, done.stdout

    def noted(self):
        return self.notes.read_text(encoding="utf-8").splitlines()


class DevInstalls(unittest.TestCase):
    def test_nothing_where_nothing_is_missing(self):
        machine = Machine(self)
        status, output = machine.run("test")
        self.assertEqual(machine.noted(), [])
        self.assertIn("dev: cmake could not configure the build", output)
        self.assertEqual(status, 1)

    def test_through_sudo(self):
        machine = Machine(self)
        _, output = machine.run("demo", "--once", MISSING="cmake")
        self.assertIn("cmake (>= 3.25)\n", output)
        self.assertEqual(
            machine.noted(),
            [
                "sudo env DEBIAN_FRONTEND=noninteractive apt-get update",
                "apt-get update",
                "frontend noninteractive",
                "sudo env DEBIAN_FRONTEND=noninteractive apt-get build-dep --no-remove -y ./",
                "apt-get build-dep --no-remove -y ./",
                "frontend noninteractive",
            ],
        )

    @unittest.skipUnless(os.geteuid() == 0, "skipped: only root can see what happens to root")
    def test_without_sudo_as_root(self):
        machine = Machine(self)
        machine.run("test", root=True, MISSING="ninja-build")
        self.assertEqual(
            machine.noted(),
            [
                "apt-get update",
                "frontend noninteractive",
                "apt-get build-dep --no-remove -y ./",
                "frontend noninteractive",
            ],
        )

    def test_nothing_without_sudo_but_says_the_command(self):
        machine = Machine(self, sudo=False)
        status, output = machine.run("test", MISSING="libmodbus-dev")
        self.assertEqual(status, 1)
        self.assertEqual(machine.noted(), [])
        self.assertIn("\n  apt-get update && apt-get build-dep --no-remove -y ./\n", output)

    def test_a_virtual_package_by_its_version(self):
        machine = Machine(self)
        _, output = machine.run("test", MISSING="debhelper")
        self.assertIn("\ndebhelper-compat (= 13)\n", output)

    def test_an_alternative_only_if_none_is_new_enough(self):
        machine = Machine(self)
        _, output = machine.run("test", MISSING="libboost1.81-dev")  # libboost-dev is 1.74
        self.assertIn("\nlibboost1.81-dev | libboost-dev (>= 1.81)\n", output)

    def test_what_the_tests_need_only_where_they_are_wanted(self):
        machine = Machine(self)
        machine.run("demo", MISSING="mbpoll", DEB_BUILD_PROFILES="nocheck")
        self.assertEqual(machine.noted(), [])
        machine.run("demo", MISSING="mbpoll")
        self.assertNotEqual(machine.noted(), [])

    def test_nothing_that_removes_and_says_why(self):
        machine = Machine(self)
        status, output = machine.run("test", MISSING="libboost1.81-dev", APT_STATUS="100")
        self.assertEqual(status, 1)
        self.assertIn("libboost1.74-dev is installed and conflicts with libboost1.81-dev.", output)
        self.assertIn("apt-get remove libboost1.74-dev", output)

    def test_nothing_for_a_wrong_command_line(self):
        machine = Machine(self)
        for arguments in ((), ("build",), ("demo", "--twice"), ("test", "--all", "--all")):
            status, output = machine.run(*arguments, MISSING="cmake")
            self.assertEqual(status, 2, arguments)
            self.assertIn("usage: ./dev demo [--once]\n       ./dev test [--all]\n", output)
        self.assertEqual(machine.noted(), [])


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
