# SPDX-License-Identifier: Apache-2.0
"""The life of the service: install, edit, start, read; reload, stop and restart under load; a late address."""

import re
import time

import modbus
import plant as plant_of
from container import eventually
from plant import AXIS, CONFIGURATION, EVERY_KEY, LINE, PORT, REGISTER, SERVICE_PORT, UNITS

# What somebody changes in the file with every key, and where: behind which line, which key, to what.
EDITS = [
    ('name = "plant"', "address", '"0.0.0.0"'),
    ('name = "plant"', "idle_timeout", '"10m"'),
    ('name = "plant"', "allow", '["127.0.0.0/8"]'),
    ('name = "line-a"', "device", f'"{LINE}"'),
    ('name = "line-a"', "baud", "115200"),
    ('name = "line-a"', "parity", '"none"'),
    ('name = "line-a"', "response_timeout", '"300ms"'),
    ('name = "line-a"', "listen_first", '"300ms"'),
    ('name = "axis-x"', "verify_word_order", "false  # as read from PR"),
    ('name = "turntable"', "response_wait", '"0s"'),
]


def edited(text):
    """The configuration with those lines changed."""
    for behind, key, value in EDITS:
        begin = text.index(f"\n{behind}")
        line = re.compile(rf"^(# )?{key} += .*$", re.MULTILINE).search(text, begin)
        text = text[: line.start()] + f"{key} = {value}" + text[line.end() :]
    return text


def install(plant, package):
    report, container = plant.report, plant.container
    plant.install(package)
    states = {unit: (plant.is_active(unit), plant.systemctl("is-enabled", unit).output) for unit in UNITS}
    report.check(
        "install: nothing is started or enabled",
        set(states.values()) == {("inactive", "disabled")},
        ", ".join(f"{unit} {' '.join(state)}" for unit, state in states.items()),
    )
    done = container.run("systemd-analyze", "--man=no", "verify", *UNITS)
    report.check("systemd-analyze verify has nothing to say of the units", done and not done.output, done)
    plant.start_drives()
    done = container.run("mbgated", "--check")
    report.check("mbgated --check of the shipped file: no bus yet", done and "no [[bus]] is configured" in done.output, done)
    shipped = container.read(EVERY_KEY)
    container.write(CONFIGURATION, edited(shipped))
    changed = sum(ours != theirs for ours, theirs in zip(edited(shipped).splitlines(), shipped.splitlines()))
    done = container.run("mbgated", "--check")
    report.check(f"edit {changed} lines, mbgated --check", bool(done), done)
    plant.systemctl("enable", "--now", "mbgated.socket")
    begin = time.monotonic()
    done = plant.systemctl("enable", "--now", "mbgated")
    report.check(
        "start: READY=1",
        done and plant.property("SubState") == "running",
        f"{done}; {time.monotonic() - begin:.2f} s; {plant.property('StatusText')}",
    )
    for port, how in ((SERVICE_PORT, "its own listener"), (PORT, "mbgated.socket")):
        values = modbus.read_once(port, AXIS, REGISTER, 2)
        report.check(f"read registers 30 and 31 through port {port} ({how})", len(values) == 2, values)
    operators(plant)
    fallen_back = plant.property("NRestarts")
    report.check("nothing had to be restarted", fallen_back == "0", f"NRestarts={fallen_back}")


def operators(plant):
    """Who may ask for the status: the group mbgate, nobody else."""
    container = plant.container
    container.must("useradd", "--groups", "mbgate", "panel")
    container.must("useradd", "stranger")
    socket = container.run("stat", "-c", "%U:%G %a", "/run/mbgate/control").output
    plant.report.check("the control socket", socket == "mbgate:mbgate 660", socket)
    for user, may in (("panel", True), ("stranger", False)):
        done = container.run("runuser", "-u", user, "--", "mbgatectl", "status")
        plant.report.check(
            f"mbgatectl status by {'a user of the group mbgate' if may else 'another user'}"
            f" is {'answered' if may else 'refused'}",
            bool(done) == may and ("line-a" in done.output) == may,
            done.output.splitlines()[0] if done.output else done,
        )


def reload(plant):
    report = plant.report
    plant.fresh()
    plant.start()
    pid = plant.main_pid()
    plant.configure(plant_of.BASE.replace('"300ms"', '"350ms"'))
    done = plant.systemctl("reload", "mbgated")
    report.check("reload of a good file", done and plant.says("350"), plant.says("350") or done)
    plant.configure(plant_of.BASE.replace("115200", '"fast"'))
    begin = time.monotonic()
    done = plant.systemctl("reload", "mbgated")
    took = time.monotonic() - begin
    report.check("reload of a bad file fails", not done, f"{done}; {took:.2f} s")
    said = plant.says("mbgate.toml", "baud")
    report.check("and the journal has the diagnostics", bool(said), said or plant.journal())
    state = plant.property("ActiveState"), plant.property("SubState")
    report.check("and the service goes on, ready", state == ("active", "running"), " ".join(state))
    values = modbus.read_once(PORT, AXIS, REGISTER)
    report.check(
        "with the process and settings of before", values and plant.main_pid() == pid, f"read {values}, pid {pid}"
    )
    plant.configure()
    done = plant.systemctl("reload", "mbgated")
    report.check("reload of the mended file", bool(done), done)


def stop(plant):
    """A PLC polls and reconnects without end; what is stopped stays stopped."""
    report = plant.report
    plant.fresh()
    plant.start()
    pollers = [modbus.Poller(port, AXIS, REGISTER, 0) for port in (PORT, SERVICE_PORT) * 4]
    for poller in pollers:
        poller.start()
    eventually(lambda: all(len(poller.served) > 5 for poller in pollers))
    begin = time.monotonic()
    plant.systemctl("stop", "mbgated")
    took = time.monotonic() - begin
    report.check("stop under load of 8 clients within 2 s", took <= 2.0, f"{took:.2f} s, {plant.property('Result')}")
    stopped = time.monotonic()
    time.sleep(5)  # what a polling client would start again, it starts in this time
    states = [plant.is_active(unit) for unit in UNITS]
    polls = sum(1 for poller in pollers for it in poller.refused if it > stopped)
    report.check(
        "5 s later, polled all the time, it is still stopped, its socket unit too",
        states == ["inactive"] * 3 and polls > 0,
        f"{', '.join(states)}; {polls} connections refused",
    )
    done = plant.systemctl("start", "mbgated")
    again = time.monotonic()
    back = eventually(lambda: all(poller.served_since(again) for poller in pollers), 10)
    report.check(
        "started again, its socket unit comes with it and all pollers are served",
        done and back and plant.is_active("mbgated.socket") == "active",
        f"{done}; mbgated.socket {plant.is_active('mbgated.socket')}; {pollers[0]}; {pollers[1]}",
    )
    for poller in pollers:
        poller.end()


def restart(plant):
    """The sockets stay open through a restart: who connects meanwhile waits and is served."""
    plant.fresh()
    plant.start()
    listeners = ((PORT, "the socket unit's"), (SERVICE_PORT, "a listener of its own, kept in the descriptor store"))
    for port, how in listeners:
        poller = modbus.Poller(port, AXIS, REGISTER)
        poller.start()
        eventually(lambda poller=poller: len(poller.served) > 5)
        times = [plant.restart() for _ in range(3)]
        ended = time.monotonic()
        back = eventually(lambda poller=poller: poller.served_since(ended) > 5, 10)
        poller.end()
        plant.report.check(
            f"3 restarts: port {port} ({how}) is never refused, its poller is served again",
            back and not poller.refused,
            f"{poller}; systemctl restart {', '.join(f'{it:.2f}' for it in times)} s",
        )


def late_address(plant):
    plant.fresh()
    address, port = "10.99.0.2", 1503
    plant.configure(
        plant_of.BASE
        + f'\n[[listen]]\nname = "late"\naddress = "{address}"\nallow = ["{address}/32"]\nport = {port}\nbus = "line-a"\n'
    )
    plant.start()
    plant.report.check("starts though an address is not there yet", plant.is_active() == "active", plant.says(address))
    plant.container.must("ip", "addr", "add", f"{address}/24", "dev", "lo")
    begin = time.monotonic()

    def served():
        try:
            return modbus.read_once(port, AXIS, REGISTER, address=address)
        except OSError:
            return None

    values = eventually(served, 30, 0.1)
    plant.report.check(
        "served there once the address has come", bool(values), f"after {time.monotonic() - begin:.1f} s: {values}"
    )
    plant.container.run("ip", "addr", "del", f"{address}/24", "dev", "lo")
