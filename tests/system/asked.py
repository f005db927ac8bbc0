#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""asked.py container|machine: for ctest, where tests of a whole system take too long unless somebody asks for them.

MBGATE_SYSTEM_DEB=FILE asks, and names the package; MBGATE_SYSTEM_OLD_DEB=FILE an earlier one to be upgraded."""

import os
import pathlib
import subprocess
import sys
import tempfile


def main():
    part = sys.argv[1]
    package = os.environ.get("MBGATE_SYSTEM_DEB")
    if not package:
        print("skipped: MBGATE_SYSTEM_DEB names no package")
        return 77
    command = ["/usr/bin/python3", str(pathlib.Path(__file__).parent / part / "run.py"), "--deb", package]
    with tempfile.TemporaryDirectory(prefix="mbgate-system-") as work:
        old = os.environ.get("MBGATE_SYSTEM_OLD_DEB")
        if part == "container" and old:
            command += ["--old-deb", old]
        return subprocess.run([*command, work], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
