#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What ./dev does about missing packages, and how it looks at files, shown with tools that only take notes."""

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
TOOLS = "awk bash cat dirname env grep kill mkdir mktemp nproc rm sed sleep sort tail xargs".split()

NOTE = '#!/bin/bash\necho "${0##*/} $*" >>"$NOTES"\n'
# Know every package but those in $MISSING.
DPKG_QUERY = """#!/bin/bash
[[ " $MISSING " == *" ${*: -1} "* ]] || echo installed
"""
DPKG_CHECKBUILDDEPS = """#!/bin/bash
control=debian/control profile=none
[[ ${1-} != -P ]] || profile=$2 control=$3
for package in $MISSING; do
  grep "^ $package\\b" "$control" | grep -qv "<!$profile>" || continue
  echo "dpkg-checkbuilddeps: error: Unmet build dependencies: $package" >&2
  exit 1
done
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
        self.add("dpkg-checkbuilddeps", DPKG_CHECKBUILDDEPS)
        self.add("install", "#!/bin/bash\n")
        self.add("git", "#!/bin/bash\nexit 128\n")  # not a checkout
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
        lines = self.notes.read_text(encoding="utf-8").splitlines()
        return [line for line in lines if not line.endswith("/usr/sbin/policy-rc.d")]


class DevInstalls(unittest.TestCase):
    def test_nothing_where_nothing_is_missing(self):
        machine = Machine(self)
        status, output = machine.run("test")
        self.assertEqual(machine.noted(), [])
        self.assertIn("dev: cmake could not configure the build", output)
        self.assertEqual(status, 1)

    def test_through_sudo(self):
        machine = Machine(self)
        _, output = machine.run("soak", MISSING="cmake")
        self.assertIn("Unmet build dependencies: cmake\n", output)
        self.assertEqual(
            machine.noted(),
            [
                "sudo env DEBIAN_FRONTEND=noninteractive apt-get update",
                "apt-get update",
                "frontend noninteractive",
                "sudo env DEBIAN_FRONTEND=noninteractive apt-get build-dep --no-remove --no-install-recommends -y ./",
                "apt-get build-dep --no-remove --no-install-recommends -y ./",
                "frontend noninteractive",
            ],
        )

    def test_for_the_demo_what_the_programs_need(self):
        machine = Machine(self)
        _, output = machine.run("demo", "--once", MISSING="libmodbus-dev")
        self.assertIn("Unmet build dependencies: libmodbus-dev\n", output)
        self.assertIn(
            "apt-get build-dep --build-profiles=nocheck --no-remove --no-install-recommends -y ./build/demo/dependencies",
            machine.noted(),
        )
        given = (ROOT / "debian/control").read_text(encoding="utf-8").splitlines()
        taken = (machine.folder / "build/demo/dependencies/debian/control").read_text(encoding="utf-8").splitlines()
        self.assertEqual(taken, [line for line in given if not line.startswith(" debhelper-compat ")])
        self.assertEqual(len(taken), len(given) - 1)

    def test_for_the_demo_nothing_of_tests_and_packaging(self):
        machine = Machine(self)
        _, output = machine.run("demo", "--once", MISSING="debhelper-compat clang-tidy-19 libgmock-dev libbenchmark-dev")
        self.assertIn("dev: cmake could not configure the build", output)
        self.assertEqual(machine.noted(), [])

    @unittest.skipUnless(os.geteuid() == 0, "skipped: only root can see what happens to root")
    def test_without_sudo_as_root(self):
        machine = Machine(self)
        machine.run("test", root=True, MISSING="ninja-build")
        self.assertEqual(
            machine.noted(),
            [
                "apt-get update",
                "frontend noninteractive",
                "apt-get build-dep --no-remove --no-install-recommends -y ./",
                "frontend noninteractive",
            ],
        )

    def test_nothing_without_sudo_but_says_the_command(self):
        machine = Machine(self, sudo=False)
        status, output = machine.run("test", MISSING="libmodbus-dev")
        self.assertEqual(status, 1)
        self.assertEqual(machine.noted(), [])
        self.assertIn("\n  apt-get update && apt-get build-dep --no-remove --no-install-recommends -y ./\n", output)

    def test_with_the_build_profiles_that_are_set(self):
        machine = Machine(self)
        machine.run("demo", MISSING="cmake", DEB_BUILD_PROFILES="nocheck")
        self.assertIn("sudo env DEBIAN_FRONTEND=noninteractive DEB_BUILD_PROFILES=nocheck apt-get update",
                      machine.noted())

    def test_the_tools_that_only_a_command_needs(self):
        for command, tool in (("test", "codespell"), ("format", "clang-format-14"), ("coverage", "gcovr"),
                              ("fuzz", "clang-19"), ("bench", "gnuplot-nox"), ("soak", "dpkg-dev"),
                              ("screenshots", "python3-selenium"), ("system --deb x", "mmdebstrap")):
            machine = Machine(self)
            machine.run(*command.split(), MISSING=tool)
            self.assertIn(f"apt-get install --no-remove --no-install-recommends -y {tool}", machine.noted())

    def test_the_browser_while_the_tests_are_built(self):
        machine = Machine(self)
        machine.add("cmake", NOTE)
        status, output = machine.run("test", MISSING="chromium-driver", APT_STATUS="100")
        self.assertEqual(status, 1)
        self.assertIn("apt-get install --no-remove --no-install-recommends -y chromium-driver", machine.noted())
        self.assertTrue(any(note.startswith("cmake --build --preset asan ") for note in machine.noted()))
        self.assertIn("dev: without a browser the status page cannot be tested: ", output)
        self.assertIn("apt-get could not install what is missing", output)

    def test_what_it_began_even_if_the_build_fails(self):
        machine = Machine(self)
        machine.add("cmake", "#!/bin/bash\n[[ $1 != --build ]]\n")
        machine.add("apt-get", '#!/bin/bash\nsleep 0.5\necho "$1 ended" >>"$NOTES"\n')
        status, _ = machine.run("test", MISSING="chromium")
        self.assertEqual(status, 1)
        self.assertIn("install ended", machine.noted())

    def test_nothing_more_once_that_failed(self):
        machine = Machine(self)
        status, output = machine.run("test", MISSING="libboost1.81-dev", APT_STATUS="100")
        self.assertEqual(status, 1)
        self.assertIn("apt-get could not install what is missing", output)
        self.assertNotIn("cmake could not configure", output)

    def test_nothing_for_a_wrong_command_line(self):
        machine = Machine(self)
        for arguments in ((), ("build",), ("demo", "--twice"), ("test", "--all", "--all"), ("format", "dev"),
                          ("fuzz", "mbap", "1", "2"), ("coverage", "1", "2"), ("demo", "--tcp", "--tcp"),
                          ("package", "arm64"), ("package", "--arch"), ("test", "--arch", "arm64", "--all"),
                          ("system", "both")):
            status, output = machine.run(*arguments, MISSING="cmake")
            self.assertEqual(status, 2, arguments)
            self.assertIn("\n  ./dev demo [--once] ", output)
        self.assertEqual(machine.run("--help")[0], 0)
        self.assertEqual(machine.noted(), [])


class DevGoesElsewhere(unittest.TestCase):
    """For another processor or suite a Debian of its own is made, and nothing of it comes to this machine."""

    def run_with(self, *arguments, **variables):
        machine = Machine(self)
        for tool in ("ls", "tar", "touch", "cp"):
            (machine.tools / tool).symlink_to(shutil.which(tool))
        machine.add("dpkg", "#!/bin/bash\necho amd64\n")
        machine.add("git", "#!/bin/bash\nprintf 'dev\\0debian/control\\0'\n")
        machine.add("mmdebstrap", NOTE + 'mkdir -p "$5"\n')
        machine.add("unshare", NOTE + 'exit "${UNSHARE_STATUS:-0}"\n')
        status, output = machine.run(*arguments, root=True, **variables)
        return machine, status, output

    def test_with_the_cross_compiler_of_the_processor(self):
        machine, _, _ = self.run_with("package", "--arch", "arm64", "--suite", "bookworm")
        root = machine.folder / "build/chroots/bookworm-arm64"
        notes = machine.noted()
        self.assertIn("mmdebstrap --variant=buildd --architectures=amd64,arm64 --include=ca-certificates,ccache,mold,"
                      f"crossbuild-essential-arm64,qemu-user bookworm {root}", notes)
        self.assertTrue((root / "source/mbgate/dev").exists())
        asked = "\n".join(notes)
        self.assertIn("apt-get --no-install-recommends -y build-dep -a arm64 -P cross,nocheck ./", asked)
        self.assertIn("dpkg-buildpackage -us -uc -b -a arm64 -Pcross,nocheck", asked)

    def test_without_one_to_another_suite(self):
        machine, _, _ = self.run_with("test", "--suite", "trixie")
        root = machine.folder / "build/chroots/trixie-amd64"
        self.assertIn("mmdebstrap --variant=buildd --architectures=amd64 --include=ca-certificates,ccache,mold "
                      f"trixie {root}", machine.noted())
        self.assertIn(" --preset asan -DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=mold -B /build ", "\n".join(machine.noted()))

    def test_with_the_emulator_to_the_tests(self):
        machine, _, _ = self.run_with("test", "--arch", "armhf", "--suite", "bookworm", "--mirror", "http://m/debian")
        asked = "\n".join(machine.noted())
        self.assertIn(f" bookworm {machine.folder}/build/chroots/bookworm-armhf http://m/debian\n", asked)
        self.assertIn(" --preset armhf -B /build ", asked)
        self.assertIn("MBGATE_EMULATOR=qemu-arm ./dev demo --once --tcp", asked)

    def test_again_to_the_same_one(self):
        machine, _, _ = self.run_with("test", "--suite", "trixie")
        machine.run("package", "--suite", "trixie", root=True)
        self.assertEqual(1, sum(note.startswith("mmdebstrap") for note in machine.noted()))

    def test_nowhere_if_there_is_no_such_processor_or_suite(self):
        for arguments, said in (
            (("--arch", "mips"), 'no package is built for "mips" on amd64: only for amd64, arm64 and armhf'),
            (("--suite", "13"), '"13" is no suite of Debian, such as bookworm or trixie'),
        ):
            machine, status, output = self.run_with("package", *arguments)
            self.assertEqual(status, 1)
            self.assertEqual(output, f"dev: {said}\n")
            self.assertEqual(machine.noted(), [])


class DevLooksAtFiles(unittest.TestCase):
    GIT = r"""#!/bin/bash
case $* in
*rev-parse*) ;;
*grep*) printf 'dev\0' ;;
*) printf 'a.cpp\0' ;;
esac
"""

    def run_with(self, failing):
        machine = Machine(self)
        machine.add("git", self.GIT)
        for tool in ("clang-format-14", "shellcheck", "codespell"):
            machine.add(tool, NOTE + f"exit {int(tool == failing)}\n")
        _, output = machine.run("test")
        self.assertEqual(machine.noted(),
                         ["clang-format-14 --dry-run -Werror a.cpp", "shellcheck dev", "codespell a.cpp"])
        return output

    def test_and_then_builds(self):
        self.assertIn("cmake could not configure", self.run_with(None))

    def test_and_builds_nothing_if_something_is_wrong(self):
        for tool, said in (("clang-format-14", "format (./dev format)"), ("shellcheck", "shellcheck"),
                           ("codespell", "codespell")):
            output = self.run_with(tool)
            self.assertIn(f"dev: failed: {said}\n", output)
            self.assertNotIn("cmake", output)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
