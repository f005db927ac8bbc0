# SPDX-License-Identifier: Apache-2.0
"""What the unit's sandbox refuses is said with the key that asks for it and the drop-in that decides; the scores."""

import os

import modbus
import plant as plant_of
from plant import AXIS, BASE, PORT, REGISTER, SERVICE_PORT, without_listener


def refused_at_start(plant, name, *words):
    """mbgated does not start, and one line of its journal has all these words."""
    done = plant.systemctl("start", "mbgated")
    status = plant.property("ExecMainStatus")
    said = plant.says(*words, patience=3)
    plant.report.check(name, not done and said, f"exit status {status}: {said or plant.journal()}")
    plant.systemctl("stop", "mbgated")
    plant.systemctl("reset-failed", "mbgated")


def served(port):
    try:
        return modbus.read_once(port, AXIS, REGISTER), ""
    except (OSError, modbus.Refused) as problem:
        return None, repr(problem)


def low_port(plant):
    report = plant.report
    plant.fresh()
    report.check("systemd-analyze security: as shipped, at most 1.2", (plant.exposure() or 9) <= 1.2, plant.exposure())
    done = plant.container.run("mbgated", "--check")
    report.check("port 502 by itself: --check names what it needs, and is content", bool(done), done)
    refused_at_start(plant, "port 502 by itself without a drop-in is refused", "plant", "port", "port-502.conf")
    plant.shipped_drop_in("port-502.conf")
    done = plant.systemctl("start", "mbgated")
    values, problem = served(PORT)
    report.check("with port-502.conf it is served", done and values, values or f"{done} {problem} {plant.journal()}")
    report.check("systemd-analyze security: with port-502.conf, at most 1.6", (plant.exposure() or 9) <= 1.6, plant.exposure())
    report.check("and its user has one capability, not root's", "0000000000000400" in capabilities(plant), capabilities(plant))


def capabilities(plant):
    """The lines Uid, CapEff and CapBnd of the main process."""
    status = plant.container.read(f"/proc/{plant.main_pid()}/status").splitlines()
    return "; ".join(" ".join(line.split()) for line in status if line.startswith(("Uid", "CapEff", "CapBnd")))


def socket_only(plant):
    report = plant.report
    plant.fresh()
    plant.shipped_drop_in("socket-only.conf")
    plant.systemctl("start", "mbgated.socket")
    refused_at_start(plant, "socket-only.conf: a listener of its own is refused", "service", "socket-only.conf")
    alone = without_listener(BASE, "service")
    plant.configure(alone + '\n[[bus]]\nname = "far"\ndevice = "tcp://127.0.0.1:4001"\n')
    plant.systemctl("start", "mbgated.socket")
    refused_at_start(plant, "socket-only.conf: a bus behind a device server is refused", "far", "socket-only.conf")
    plant.configure(alone)
    plant.systemctl("start", "mbgated.socket")
    done = plant.systemctl("start", "mbgated")
    values, problem = served(PORT)
    report.check("socket-only.conf: what systemd listens for is served", done and values,
                 values or f"{done} {problem} {plant.journal()}")
    report.check("systemd-analyze security: with socket-only.conf, at most 0.5", (plant.exposure() or 9) <= 0.5, plant.exposure())
    plant.mark()
    plant.configure(BASE)
    done = plant.systemctl("reload", "mbgated")
    report.check("socket-only.conf: a reload that would listen by itself is refused, and names it",
                 not done and "service" in done.output + plant.journal() and "socket-only.conf" in done.output + plant.journal(),
                 done)
    values, problem = served(PORT)
    report.check("and the service goes on", bool(values), values or problem)


def terminals(plant):
    """Device nodes of a driver that the unit does not list, and of one that it does."""
    drivers = [line.split() for line in plant.container.read("/proc/devices").split("Block devices")[0].splitlines()[1:]]
    majors = {words[1]: words[0] for words in drivers if len(words) == 2}
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
    refused_at_start(plant, "--record outside of /var/lib/mbgate is refused", "/etc/mbgate/plant.rec")
    there = plant.container.path("/etc/mbgate/plant.rec").exists()
    plant.report.check("and no file is there", not there, "none" if not there else "there is one")
    plant.drop_in("record.conf", "[Service]\nExecStart=\nExecStart=/usr/sbin/mbgated --record plant.rec\n")
    plant.start()
    values, problem = served(SERVICE_PORT)
    recording = plant.container.run("stat", "-L", "-c", "%U:%G %a %s bytes", "/var/lib/mbgate/plant.rec")
    plant.report.check("inside it is written, for its user alone", values and recording and " 600 " in recording.output,
                       f"{problem} {recording}")
