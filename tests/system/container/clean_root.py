# SPDX-License-Identifier: Apache-2.0
"""From a clean Debian root to a register that was read: build, install, edit, start, read, status."""

import os
import pathlib
import shutil
import subprocess
import time

import modbus
from checks_service import edited
from container import Container
from plant import AXIS, CONFIGURATION, PORT, REGISTER, Plant
from root import make_root

CHECKOUT = pathlib.Path(__file__).parents[3]


class Watch:
    """Says how long each step took, and all of them."""

    def __init__(self, report):
        self.report = report
        self.begin = self.last = time.monotonic()

    def step(self, name, holds=True, seen=""):
        now = time.monotonic()
        self.report.check(name, holds, f"{now - self.last:.1f} s; {seen}".rstrip("; "))
        self.last = now

    def total(self):
        return time.monotonic() - self.begin


def in_root(root, command, log):
    """Runs a line of shell in the root, with the host's network; raises with the end of what it printed."""
    done = subprocess.run(
        ["systemd-nspawn", "--quiet", "--register=no", "--keep-unit", "--as-pid2", "--resolv-conf=copy-host",
         "-D", root, "--setenv=DEBIAN_FRONTEND=noninteractive", "--setenv=DEB_BUILD_PROFILES=nocheck",
         f"--setenv=DEB_BUILD_OPTIONS=nocheck parallel={os.cpu_count()}", "sh", "-ec", command],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        check=False,
    )
    with open(log, "a", encoding="utf-8") as file:
        file.write(done.stdout)
    if done.returncode != 0:
        raise RuntimeError(f"{command}: status {done.returncode}: {done.stdout[-3000:]}")
    return done.stdout


def from_source(report, work, suite):
    watch = Watch(report)
    log = work / "clean-root.log"
    tree = make_root(work, suite, [])
    watch.step(f"a Debian root ({suite})", tree.exists(), "with systemd, and nothing of ours")
    root = work / "clean-root"
    shutil.rmtree(root, ignore_errors=True)
    subprocess.run(["cp", "-a", tree, root], check=True)
    (root / "src/mbgate").mkdir(parents=True)
    # The checkout may belong to another user.
    git = ["git", "-c", f"safe.directory={CHECKOUT}", "-C", CHECKOUT]
    archive = subprocess.run([*git, "archive", "HEAD"], check=True, stdout=subprocess.PIPE).stdout
    subprocess.run(["tar", "-x", "-C", root / "src/mbgate"], input=archive, check=True)
    watch.step("the sources", True, f"{len(archive) / 1e6:.1f} MB by git archive")
    in_root(root, "apt-get update && apt-get install -y --no-install-recommends dpkg-dev"
                  " && cd /src/mbgate && apt-get build-dep -y --no-install-recommends -P nocheck ./", log)
    watch.step("apt-get build-dep ./")
    in_root(root, "cd /src/mbgate && dpkg-buildpackage -us -uc -b", log)
    packages = sorted(path.name for path in (root / "src").glob("mbgate_*.deb"))
    watch.step("dpkg-buildpackage", len(packages) == 1, ", ".join(packages))
    try:
        serve(report, watch, root, work, root / "src" / packages[0])
    finally:
        shutil.rmtree(root, ignore_errors=True)


def serve(report, watch, root, work, package):
    container = Container(root, work, f"mbgate-{os.getpid()}-c", volatile=False)
    try:
        container.boot()
        plant = Plant(container, report)
        plant.mark()
        plant.install(package)
        watch.step("boot and install")
        plant.start_drives()
        container.write(CONFIGURATION, edited(container.read(CONFIGURATION)))
        done = container.run("mbgated", "--check")
        watch.step("edit, mbgated --check", bool(done), done)
        plant.start()
        watch.step("start", plant.property("SubState") == "running", plant.property("StatusText"))
        values = modbus.read_once(PORT, AXIS, REGISTER, 2)
        watch.step("read", len(values) == 2, values)
        done = container.run("mbgatectl", "status")
        watch.step("status", bool(done) and "line-a" in done.output, done.output.splitlines()[0])
        report.told("from nothing to the status", f"{watch.total():.0f} s")
    finally:
        container.end()
