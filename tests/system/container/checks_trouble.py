# SPDX-License-Identifier: Apache-2.0
"""mbgated hangs, is killed, or waits for what never answers: systemd brings it back, or has no reason to."""

import threading
import time

import modbus
from container import eventually
from plant import AXIS, BASE, PORT, REGISTER, SERVICE_PORT, without_listener


def restarts(plant):
    return int(plant.property("NRestarts"))


def hang(plant):
    report = plant.report
    plant.fresh()
    plant.drop_in("watchdog.conf", "[Service]\nWatchdogSec=2s\n")
    plant.start()
    # A drive that never answers and an adapter that is absent, for longer than the watchdog's time.
    quiet = modbus.Poller(SERVICE_PORT, 99, 0, 0)
    quiet.start()
    time.sleep(6)
    quiet.end()
    report.check(
        "6 s with WatchdogSec=2s, an absent adapter and a drive that never answers are no hang",
        restarts(plant) == 0 and plant.is_active() == "active",
        f"NRestarts={restarts(plant)}, {len(quiet.codes)} exceptions {set(quiet.codes)}",
    )
    before = restarts(plant)
    pid = plant.signal("STOP")
    begin = time.monotonic()
    ended = eventually(lambda: plant.main_pid() != pid, 20)
    took = time.monotonic() - begin
    said = plant.says("atchdog timeout")
    report.check("SIGSTOP: the watchdog ends it", ended and said, f"after {took:.1f} s: {said or plant.journal()}")
    values = eventually(lambda: read_if_served(PORT), 20, 0.1)
    took = time.monotonic() - begin
    report.check(
        "and it is back by itself", values and restarts(plant) == before + 1,
        f"served again after {took:.1f} s; NRestarts={restarts(plant)}",
    )


def hang_socket_only(plant):
    """The same where systemd has all sockets: what stops mbgated.socket must not keep mbgated from coming back."""
    plant.fresh()
    plant.drop_in("watchdog.conf", "[Service]\nWatchdogSec=2s\n")
    plant.shipped_drop_in("socket-only.conf")
    plant.configure(without_listener(BASE, "service"))
    plant.start()
    pid = plant.signal("STOP")
    values = eventually(lambda: plant.main_pid() not in (0, pid) and read_if_served(PORT), 30, 0.2)
    plant.report.check("with socket-only.conf too", bool(values), values or plant.journal())


def read_if_served(port):
    try:
        return modbus.read_once(port, AXIS, REGISTER)
    except (OSError, modbus.Refused):
        return None


class Visitor(threading.Thread):
    """Connects once, and waits for one answer."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port = port
        self.seen = "nothing"
        self.served = False
        self.start()

    def run(self):
        begin = time.monotonic()
        try:
            self.seen = modbus.read_once(self.port, AXIS, REGISTER)
            self.served = True
        except (OSError, ValueError, modbus.Refused) as problem:
            self.seen = repr(problem)
        self.seen = f"{self.seen} after {time.monotonic() - begin:.2f} s"


def kill(plant):
    report = plant.report
    plant.fresh()
    plant.start()
    poller = modbus.Poller(PORT, AXIS, REGISTER)
    poller.start()
    eventually(lambda: len(poller.served) > 5)
    before = restarts(plant)
    killed = time.monotonic()
    pid = plant.signal("KILL")
    eventually(lambda: plant.main_pid() != pid, 5)
    visitor = Visitor(SERVICE_PORT)  # in the second in which nobody is there
    visitor.join(20)
    report.check(
        f"kill -9: a client that connects to port {SERVICE_PORT} meanwhile is served (descriptor store)",
        visitor.served, visitor.seen,
    )
    back = eventually(lambda: poller.served_since(killed + 0.1), 15)
    poller.end()
    refused = [it - killed for it in poller.refused]
    report.check(
        f"and a client that polls port {PORT} (socket unit) is served again", back,
        f"refused from {refused[0]:.2f} to {refused[-1]:.2f} s after" if refused else "never refused",
    )
    report.check(
        "and the service is back by itself", plant.is_active() == "active" and plant.main_pid() != pid,
        f"NRestarts {before} -> {restarts(plant)}",
    )
