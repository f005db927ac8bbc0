# SPDX-License-Identifier: Apache-2.0
"""An upgrade under load, and what is left after a purge."""

import time

import modbus
from container import eventually
from plant import AXIS, BASE, CONFIGURATION, DROP_INS, PORT, REGISTER, SERVICE_PORT, UNITS

# What dpkg, the journal and the tools for accounts keep for themselves, and what we have made.
NOT_OURS = (
    "/proc", "/sys", "/dev", "/run", "/tmp", "/root", "/home", "/var/log", "/var/tmp", "/var/cache", "/var/lib/dpkg",
    "/var/lib/systemd", "/etc/passwd-", "/etc/group-", "/etc/shadow-", "/etc/gshadow-", "/etc/.pwd.lock",
    "/etc/drives.toml", "/var/lib/private", "/var/spool/mail",
)


def files(container):
    """All files but those that no package owns."""
    skipped = [word for path in NOT_OURS for word in ("-path", path, "-o")][:-1]
    return set(container.must("find", "/", "(", *skipped, ")", "-prune", "-o", "-print").splitlines())


def upgrade(plant, old, new):
    """A gateway of the old package runs under load while the new one is unpacked and configured."""
    report, container = plant.report, plant.container
    plant.install(old)
    plant.start_drives()
    ours = BASE.replace(f"port = {PORT}", "port = 1503")
    plant.configure(ours)
    record = "[Service]\nExecStart=\nExecStart=/usr/sbin/mbgated --record plant.rec\n"
    plant.drop_in("record.conf", record)
    plant.mark()
    done = plant.systemctl("enable", "--now", "mbgated")
    if not done:
        raise RuntimeError(f"the old package's gateway does not start: {done} {plant.journal()}")
    pid = plant.main_pid()
    user = container.run("stat", "-c", "%u", f"/proc/{pid}").output
    pollers = [modbus.Poller(SERVICE_PORT, AXIS, REGISTER, 0) for _ in range(4)]
    for poller in pollers:
        poller.start()
    eventually(lambda: all(len(poller.served) > 5 for poller in pollers))
    before = time.monotonic()
    plant.install(new)
    time.sleep(1)
    report.check(
        f"upgrade under load of 4 clients: the running gateway (user {user}) is not touched",
        plant.main_pid() == pid and all(poller.served_since(before) and not poller.lost for poller in pollers),
        f"pid {pid} -> {plant.main_pid()}; " + "; ".join(map(str, pollers[:2])),
    )
    states = [plant.is_active(unit) for unit in UNITS], [plant.systemctl("is-enabled", unit).output for unit in UNITS]
    report.check("nothing is started or enabled by it",
                 states == (["active", "inactive", "inactive"], ["enabled", "disabled", "disabled"]), states)
    kept = container.read(CONFIGURATION) == ours and container.read(f"{DROP_INS}/record.conf") == record
    report.check("what was edited is kept", kept)
    took = plant.restart()
    restarted = time.monotonic()
    back = eventually(lambda: all(poller.served_since(restarted) for poller in pollers), 15)
    for poller in pollers:
        poller.end()
    user = container.run("stat", "-c", "%U:%G", f"/proc/{plant.main_pid()}").output
    report.check("restarted, it runs as mbgate:mbgate and its clients are served again",
                 back and user == "mbgate:mbgate", f"{user}; {took:.2f} s; {pollers[0]}")
    recordings(plant)


def recordings(plant):
    """What the dynamic user had recorded is there, and the new user may read it."""
    container = plant.container
    folder = container.run("stat", "-c", "%F %U:%G %a", "/var/lib/mbgate").output
    count = "cd /var/lib/mbgate && wc -c plant.rec plant.rec.1"
    listed = container.run("runuser", "-u", "mbgate", "--", "sh", "-c", count)
    plant.report.check("the recording of before the upgrade is kept, and read by the new user",
                       bool(listed) and folder.startswith("directory mbgate:mbgate"), f"{folder}; {listed}")
    done = container.run("runuser", "-u", "mbgate", "--", "mbgatectl", "replay", "/var/lib/mbgate/plant.rec.1")
    plant.report.told("mbgatectl replay of it", done.output.splitlines()[-1] if done.output else done)


def purge(plant, before):
    """Compares with the files of before the first installation."""
    report, container = plant.report, plant.container
    plant.systemctl("enable", "--now", "mbgated.socket")
    plant.systemctl("restart", "mbgated")
    done = container.run("dpkg", "-P", "mbgate")
    report.check("purge while it runs", bool(done), done if not done else "")
    processes = container.run("pgrep", "-x", "mbgated").output
    sockets = [line for line in container.run("ss", "-Hltn").output.splitlines() if ":502 " in line or ":1502 " in line]
    report.check("no process and no listening socket is left", not processes and not sockets, f"{processes} {sockets}")
    listed = ("systemctl", "list-units", "--all", "--plain", "--no-legend", "mbgate*")
    # systemd forgets them when it has nothing else to do.
    eventually(lambda: not container.run(*listed).output, 10)
    units = container.run(*listed).output
    files_of_units = container.run("systemctl", "list-unit-files", "--no-legend", "mbgate*").output
    report.check("no unit is left", not units and not files_of_units, f"{units} {files_of_units}".strip() or "none")
    # What the administrator has made is not the package's: the drop-in.
    container.run("rm", "-rf", DROP_INS)
    left = sorted(files(container) - before)
    report.check("no file is left", not left, ", ".join(left[:20]) or "none")
    gone = sorted(before - files(container))
    report.check("and none of before is missing", not gone, ", ".join(gone[:20]) or "none")
    state = [path for path in ("/var/lib/mbgate", "/var/lib/private/mbgate", "/run/mbgate", "/run/mbgate-signer")
             if container.run("test", "-e", path)]
    report.check("no recording, no control socket", not state, ", ".join(state) or "none")
    accounts = container.run("getent", "passwd", "mbgate", "mbgate-tls")
    report.check("the users stay, as Debian advises", bool(accounts), accounts)
