#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The Debian package under a real systemd, in a container: each check is a line with what was seen.

Exit status: 0 all checks passed, 1 some failed, 77 it cannot run here. It has to be run by root, and changes nothing
outside its folder."""

import argparse
import os
import pathlib
import shutil
import signal
import sys
import tempfile

import checks_journal
import checks_package
import checks_restart
import checks_sandbox
import checks_service
import checks_tls
import checks_trouble
import clean_root
from container import Container
from plant import Plant
from report import Report
from root import dependencies, make_root, missing_tool

TOPICS = {
    "reload": checks_service.reload,
    "hang": checks_trouble.hang,
    "hang-socket-only": checks_trouble.hang_socket_only,
    "kill": checks_trouble.kill,
    "stop": checks_service.stop,
    "restart": checks_service.restart,
    "load": checks_restart.under_load,
    "address": checks_service.late_address,
    "port": checks_sandbox.low_port,
    "sockets": checks_sandbox.socket_only,
    "terminals": checks_sandbox.terminals,
    "writes": checks_sandbox.writes,
    "journal": checks_journal.fields,
    "tls": checks_tls.security,
}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--deb", metavar="FILE", help="the package")
    parser.add_argument("--old-deb", metavar="FILE", help="an earlier package, for the upgrade")
    parser.add_argument("--suite", default="bookworm", choices=["bookworm", "trixie"])
    parser.add_argument(
        "folder", nargs="?", help="where the root is made, and kept for the next time; default: one that is removed"
    )
    parser.add_argument("--rows", metavar="FILE", help="what was seen, as rows of a table of Markdown too")
    parser.add_argument("--only", metavar="TOPIC,...", help="of " + ", ".join([*TOPICS, "upgrade", "purge"]))
    parser.add_argument(
        "--clean-root", action="store_true",
        help="instead: builds the package of HEAD in a new root, installs it there and reads a drive",
    )
    return parser.parse_args()


def reason_to_skip(options):
    if not options.deb and not options.clean_root:
        return "no package is named (--deb FILE)"
    if os.geteuid() != 0:
        return "only root can boot a container"
    tool = missing_tool("systemd-nspawn", "mmdebstrap", "nsenter", "dpkg-deb")
    return f"{tool} is not installed" if tool else None


def in_service(options, root, work, report):
    """The installed package through all of its life but its end."""
    container = Container(root, work, f"mbgate-{os.getpid()}-a")
    try:
        report.check("systemd has booted", container.boot() == "running",
                     container.run("systemctl", "--version").output.splitlines()[0])
        plant = Plant(container, report)
        report.topic("install", checks_service.install, plant, options.deb)
        for name, function in TOPICS.items():
            if wanted(options, name):
                report.topic(name, function, plant)
    finally:
        container.end()


def its_end(options, root, work, report):
    """Upgrade and purge, in a container of their own."""
    container = Container(root, work, f"mbgate-{os.getpid()}-b")
    try:
        container.boot()
        plant = Plant(container, report)
        before = checks_package.files(container)
        if options.old_deb and wanted(options, "upgrade"):
            report.topic("upgrade", checks_package.upgrade, plant, options.old_deb, options.deb)
        else:
            report.told("upgrade", "skipped: no --old-deb FILE")
            plant.install(options.deb)
            plant.start_drives()
            plant.configure()
        report.topic("purge", checks_package.purge, plant, before)
    finally:
        container.end()


def wanted(options, name):
    return not options.only or name in options.only.split(",")


def main():
    options = arguments()
    reason = reason_to_skip(options)
    if reason:
        print(f"skipped: {reason}")
        return 77
    work = pathlib.Path(options.folder or tempfile.mkdtemp(prefix="mbgate-system-")).resolve()
    work.mkdir(parents=True, exist_ok=True)
    report = Report()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        if options.clean_root:
            report.topic("clean root", clean_root.from_source, report, work, options.suite)
            return report.finish()
        packages = [file for file in (options.deb, options.old_deb) if file]
        root = make_root(work, options.suite, dependencies(*packages))
        if not options.only or set(options.only.split(",")) & set(TOPICS):
            in_service(options, root, work, report)
        if wanted(options, "upgrade") or wanted(options, "purge"):
            its_end(options, root, work, report)
        return report.finish()
    finally:
        if options.rows:
            pathlib.Path(options.rows).write_text(report.rows(f"nspawn, {options.suite}"), encoding="utf-8")
        if not options.folder:
            shutil.rmtree(work, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
