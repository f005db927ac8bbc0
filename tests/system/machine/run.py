#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The package on a whole machine, emulated, with two FT232R adapters that are plugged in from outside: the real kernel,
the real ftdi_sio, the real systemd. Prints a line for each check with what was seen. Exit status 1: a check failed;
77: it cannot be run here."""

import argparse
import pathlib
import shutil
import sys
import tarfile
import tempfile
import time
import traceback

import checks_adapters
import checks_clock
import checks_faults
from adapters import Adapters
from guest import Guest
from image import Image, missing
from plant import Plant

SKIPPED = 77

# In this order: the first two plug the adapters in, and `unplug` leaves one out, which `other_node` plugs in again.
CHECKS = (
    ("hot-plug after the start", checks_adapters.hot_plug),
    ("rate and format at the chip", checks_adapters.settings),
    ("latency timer", checks_adapters.latency),
    ("clock set forward an hour", checks_clock.forward),
    ("clock set back an hour", checks_clock.back),
    ("MemoryMax", checks_faults.memory_max),
    ("no memory left", checks_faults.out_of_memory),
    ("kill -9", checks_faults.killed),
    ("watchdog", checks_faults.watchdog),
    ("full disk", checks_faults.full_disk),
    ("read-only root", checks_faults.read_only_root),
    ("realtime.conf", checks_faults.realtime),
    ("parity errors", checks_adapters.parity),
    ("an adapter that hears itself", checks_adapters.echo),
    ("unplugged in mid-transaction", checks_adapters.unplug),
    ("another device node", checks_adapters.other_node),
)
ALWAYS = (checks_adapters.hot_plug,)


def wanted(words):
    """The checks whose names have one of these words; all without words."""
    found = [(name, check) for name, check in CHECKS
             if not words or check in ALWAYS or any(word in name for word in words)]
    if any(check is checks_adapters.other_node for _, check in found):
        found = [each for each in found if each[1] is not checks_adapters.unplug][:-1] + list(CHECKS[-2:])
    return found


def run_check(plant, name, check):
    """True if it held."""
    begun = time.monotonic()
    try:
        seen, verdict = check(plant), "ok    "
    except Exception as error:  # a check that cannot be carried out has failed, the others are still of use
        seen, verdict = f"{type(error).__name__}: {error}", "FAILED"
        traceback.print_exc(file=sys.stderr)
    print(f"{verdict} {name} ({time.monotonic() - begun:.0f} s): {seen}", flush=True)
    return verdict != "FAILED"


def run_all(guest, checks):
    plant = Plant(guest)
    plant.install()
    with Adapters(guest, plant.a, plant.b) as plant.adapters:
        results = [run_check(plant, name, check) for name, check in checks]
        if not all(results):
            print(guest.ask("journalctl -u mbgated --no-pager | tail -n 200")[0], file=sys.stderr)
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--deb", required=True, type=pathlib.Path, help="the package of mbgate, of this processor")
    parser.add_argument("--only", action="append", default=[], metavar="WORD", help="checks with this in their names")
    parser.add_argument("folder", type=pathlib.Path, help="where the image is made, and kept for the next time")
    options = parser.parse_args()
    packages = missing()
    if packages:
        print(f"skipped: not installed: {' '.join(packages)}")
        return SKIPPED
    begun = time.monotonic()
    image = Image(options.folder.resolve() / "image", options.deb)
    print("made the image" if image.make() else "the image is there", f"({time.monotonic() - begun:.0f} s)", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        payload = pathlib.Path(folder) / "payload"
        with tarfile.open(payload, "w") as archive:
            archive.add(options.deb, "mbgate.deb")
        begun = time.monotonic()
        with Guest(image, payload) as guest:
            kernel = guest.run("systemctl is-system-running --wait >/dev/null; uname -r")
            print(f"Linux {kernel} is up ({time.monotonic() - begun:.0f} s)", flush=True)
            results = run_all(guest, wanted(options.only))
    print(f"{sum(results)} of {len(results)} checks held ({time.monotonic() - begun:.0f} s)")
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
