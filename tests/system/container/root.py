# SPDX-License-Identifier: Apache-2.0
"""Debian roots made by mmdebstrap: with what the package depends on, so that it installs without a network."""

import hashlib
import pathlib
import re
import shutil
import subprocess

# systemd as the first process, and what the checks themselves use.
ALWAYS = ["systemd-sysv", "udev", "dbus", "libpam-systemd", "libnss-systemd", "iproute2", "netbase", "procps", "kmod"]


def missing_tool(*tools):
    """The first of these programs that is not there, or None."""
    return next((tool for tool in tools if shutil.which(tool) is None), None)


def dependencies(*packages):
    """What the .deb files depend on, the first of alternatives, without versions."""
    names = set()
    for package in packages:
        for field in ("Depends", "Pre-Depends"):
            text = subprocess.run(
                ["dpkg-deb", "-f", package, field], check=True, stdout=subprocess.PIPE, text=True
            ).stdout
            names.update(re.split(r"[\s(|:]", one.strip())[0] for one in text.split(",") if one.strip())
    return sorted(names)


def make_root(work, suite, packages):
    """A folder with a root of that suite; an earlier one with the same packages is taken again."""
    include = ALWAYS + [name for name in packages if name not in ALWAYS]
    key = hashlib.sha256(" ".join(include).encode()).hexdigest()[:8]
    root = pathlib.Path(work) / f"root-{suite}-{key}"
    if root.exists():
        return root
    unfinished = root.with_suffix(".unfinished")
    shutil.rmtree(unfinished, ignore_errors=True)
    done = subprocess.run(
        ["mmdebstrap", "--quiet", "--variant=minbase", "--include=" + ",".join(include), suite, unfinished],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(f"mmdebstrap could not make a root of {suite}: {done.stdout[-2000:]}")
    unfinished.rename(root)
    return root
