# SPDX-License-Identifier: Apache-2.0
"""What the unit's sandbox refuses is said with the key that asks for it and the drop-in that decides; the scores."""

import os
import urllib.request

import modbus
import plant as plant_of
from plant import AXIS, BASE, PORT, REGISTER, SERVICE_PORT, without_listener


def refused_at_start(plant, name, status, *words):
    """mbgated does not start, ends with this status, and one line of its journal has all these words."""
    done = plant.systemctl("start", "mbgated")
    seen = plant.property("ExecMainStatus")
    said = plant.says(*words, patience=3)
    plant.report.check(
        name, not done and said and seen == str(status), f"exit status {seen}: {said or plant.journal()}"
    )
    plant.systemctl("stop", "mbgated")
    plant.systemctl("reset-failed", "mbgated")


def exposure(plant, how, limit):
    score = plant.exposure()
    plant.report.check(f"systemd-analyze security: {how}, at most {limit}", score is not None and score <= limit, score)


def served(port):
    try:
        return modbus.read_once(port, AXIS, REGISTER), ""
    except (OSError, modbus.Refused) as problem:
        return None, repr(problem)


def low_port(plant):
    report = plant.report
    plant.fresh()
    exposure(plant, "as shipped", 1.2)
    done = plant.container.run("mbgated", "--check")
    named = "port 502" in done.output and "port-502.conf" in done.output
    report.check("port 502 by itself: --check names what it needs, and is content", done and named, done)
    refused_at_start(plant, "port 502 by itself without a drop-in is refused", 78, '"plant"', "port", "port-502.conf")
    plant.shipped_drop_in("port-502.conf")
    done = plant.systemctl("start", "mbgated")
    values, problem = served(PORT)
    report.check("with port-502.conf it is served", done and values, values or f"{done} {problem} {plant.journal()}")
    exposure(plant, "with port-502.conf", 1.6)
    held = capabilities(plant)
    report.check("and its user has that capability alone", held.count("0000000000000400") == 2, held)


def capabilities(plant):
    """The lines Uid, CapEff and CapBnd of the main process."""
    status = plant.container.read(f"/proc/{plant.main_pid()}/status").splitlines()
    return "; ".join(" ".join(line.split()) for line in status if line.startswith(("Uid", "CapEff", "CapBnd")))


def socket_only(plant):
    report = plant.report
    plant.fresh()
    plant.shipped_drop_in("socket-only.conf")
    plant.systemctl("start", "mbgated.socket")
    refused_at_start(plant, "socket-only.conf: a listener of its own is refused", 78, '"service"', "socket-only.conf")
    alone = without_listener(BASE, "service")
    plant.configure(alone + '\n[[bus]]\nname = "far"\ndevice = "tcp://127.0.0.1:4001"\n')
    plant.systemctl("start", "mbgated.socket")
    plant.systemctl("start", "mbgated")
    said = plant.says("far", "socket-only.conf", patience=3)
    report.check("socket-only.conf: a bus behind a device server cannot connect, and says why", said, said)
    plant.systemctl("stop", "mbgated")
    plant.configure(alone)
    plant.systemctl("start", "mbgated.socket", "mbgated-http.socket")
    done = plant.systemctl("start", "mbgated")
    values, problem = served(PORT)
    report.check("socket-only.conf: what systemd listens for is served", done and values,
                 values or f"{done} {problem} {plant.journal()}")
    report.check("and the status over HTTP too", "buses" in over_http(), over_http()[:60])
    exposure(plant, "with socket-only.conf", 0.5)
    plant.mark()
    plant.configure(BASE)
    done = plant.systemctl("reload", "mbgated")
    said = plant.says('"service"', "socket-only.conf", patience=3)
    report.check(
        "socket-only.conf: a reload that would listen by itself is refused, and names it",
        not done and said,
        said or done,
    )
    values, problem = served(PORT)
    report.check("and the service goes on", bool(values), values or problem)


def over_http():
    """The status by mbgated-http.socket, or what went wrong."""
    try:
        with urllib.request.urlopen("http://127.0.0.1:8080/api/v1/status", timeout=10) as answer:
            return answer.read().decode()
    except OSError as problem:
        return repr(problem)


def terminals(plant):
    """Device nodes of a driver that the unit does not list, and of one that it does."""
    characters = plant.container.read("/proc/devices").split("Block devices")[0].splitlines()[1:]
    majors = {words[1]: words[0] for words in map(str.split, characters) if len(words) == 2}
    foreign = next(major for name, major in majors.items() if name in ("input", "fb", "misc", "mem"))
    make_node(plant, "/dev/ttyFOREIGN0", foreign, 200)
    plant.fresh()
    plant.configure(BASE.replace(plant_of.ABSENT, "/dev/ttyFOREIGN0"))
    plant.systemctl("start", "mbgated.socket")
    plant.systemctl("start", "mbgated")
    said = plant.says("ttyFOREIGN0", "DeviceAllow")
    plant.report.check("a port whose driver DeviceAllow= does not list: EPERM, and that is said", bool(said),
                       said or plant.journal())
    if "ttyS" not in majors:
        plant.report.told("a port of a driver that is listed", "skipped: this kernel has no ttyS")
        return
    make_node(plant, "/dev/ttyS60", majors["ttyS"], 124)
    plant.fresh()
    plant.configure(BASE.replace(plant_of.ABSENT, "/dev/ttyS60"))
    plant.systemctl("start", "mbgated.socket")
    plant.systemctl("start", "mbgated")
    said = plant.says("ttyS60")
    plant.report.check("of a listed driver (ttyS, without hardware) it is not the sandbox that refuses",
                       said and "DeviceAllow" not in said and "not permitted" not in said, said or plant.journal())


def make_node(plant, path, major, minor):
    node = plant.container.path(path)
    node.unlink(missing_ok=True)
    os.mknod(node, 0o20660, os.makedev(int(major), minor))
    plant.container.must("chgrp", "dialout", path)
    plant.container.must("chmod", "660", path)


def writes(plant):
    """Outside of /var/lib/mbgate nothing can be written."""
    plant.fresh()
    plant.drop_in("record.conf", "[Service]\nExecStart=\nExecStart=/usr/sbin/mbgated --record /etc/mbgate/plant.rec\n")
    plant.systemctl("start", "mbgated.socket")
    refused_at_start(plant, "--record outside of /var/lib/mbgate is refused", 73, "/etc/mbgate/plant.rec")
    there = plant.container.path("/etc/mbgate/plant.rec").exists()
    plant.report.check("and no file is there", not there, "none" if not there else "there is one")
    plant.drop_in("record.conf", "[Service]\nExecStart=\nExecStart=/usr/sbin/mbgated --record plant.rec\n")
    plant.start()
    values, problem = served(SERVICE_PORT)
    recording = plant.container.run("stat", "-L", "-c", "%U:%G %a %s bytes", "/var/lib/mbgate/plant.rec")
    plant.report.check("inside it is written, for its user alone", values and recording and " 600 " in recording.output,
                       f"{problem} {recording}")
