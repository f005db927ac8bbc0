# SPDX-License-Identifier: Apache-2.0
"""The machine's own faults: memory, disks, a process that hangs or is killed."""

import re

from client import Poller

POLLED, VALUE = 11, 4711
SMALL_DISK = "mount -t tmpfs -o size=64k,mode=0700,uid={uid},gid={gid} tmpfs {folder}"


def _begin(plant):
    plant.remove_drop_ins()
    plant.configure()
    plant.restart()
    plant.wait_until_served(1)
    plant.wait_until_served(POLLED)
    plant.b.line.registers[1][0] = VALUE


def _wait_for_restart(plant, before):
    """Until systemd has started it again by itself and a drive answers; the journal's lines of systemd."""
    plant.guest.wait_for(f"test $(systemctl show mbgated -P NRestarts) -gt {before} "
                         "&& systemctl is-active -q mbgated", "systemd starts mbgated again", 120)
    plant.wait_until_served(1)


def killed(plant):
    """kill -9: back by itself."""
    _begin(plant)
    mark, pid = plant.mark(), plant.show("MainPID")
    plant.guest.run(f"kill -9 {pid}")
    _wait_for_restart(plant, 0)
    (line,) = plant.journal(mark, "Main process exited")
    return f"{line.split(': ', 1)[1]}; started again, served"


def watchdog(plant):
    """A process that hangs is ended and started again."""
    if plant.show("WatchdogUSec") == "0":
        raise AssertionError("the unit has no watchdog")
    _begin(plant)
    plant.drop_in("watchdog", "[Service]\nWatchdogSec=10s")
    plant.restart()
    plant.wait_until_served(1)
    mark = plant.mark()
    plant.guest.run("kill -STOP $(systemctl show mbgated -P MainPID)")
    _wait_for_restart(plant, 0)
    lines = plant.journal(mark, "[Ww]atchdog timeout")
    assert lines, plant.journal(mark)
    return f"{lines[0]}; started again, served"


def memory_max(plant):
    """More memory than MemoryMax= allows: killed, and started again."""
    _begin(plant)
    mark, before = plant.mark(), int(plant.show("MemoryCurrent"))
    # It needs more than this to live; so the limit is taken back as soon as it has done its work.
    plant.guest.run("systemctl set-property --runtime mbgated MemoryMax=512K")
    try:
        plant.guest.wait_for("test $(systemctl show mbgated -P NRestarts) -gt 0 "
                             "|| systemctl show mbgated -P Result | grep -q oom-kill", "mbgated is killed")
    finally:
        plant.guest.run("systemctl set-property --runtime mbgated MemoryMax=infinity")
    _wait_for_restart(plant, 0)
    lines = plant.journal(mark, "oom-kill|OOM killer")
    assert lines, plant.journal(mark)
    return f"it had {before // 1024} KiB, MemoryMax= was set to 512 KiB: {lines[0]}; started again, served"


def out_of_memory(plant):
    """The kernel's choice when the whole machine has no memory left."""
    _begin(plant)
    mark, pid = plant.mark(), plant.show("MainPID")
    shipped = plant.guest.run(f"cat /proc/{pid}/oom_score_adj")
    plant.guest.run(f"echo 1000 >/proc/{pid}/oom_score_adj; echo f >/proc/sysrq-trigger")
    _wait_for_restart(plant, 0)
    lines = plant.journal(mark, "oom-kill|OOM killer|status=9/KILL")
    assert lines, plant.journal(mark)
    return f"oom_score_adj was {shipped}; made the kernel's first choice: {lines[0]}; started again, served"


def full_disk(plant):
    """--record on a disk that becomes full: the bus goes on."""
    _begin(plant)
    folder = "/var/lib/mbgate"
    plant.drop_in("record", f"[Service]\nExecStart=\nExecStart=/usr/sbin/mbgated --record {folder}/full.rec")
    real = plant.guest.run(f"readlink -f {folder}")
    uid, gid = plant.guest.run(f"stat -c '%u %g' {real}").split()
    plant.guest.run("systemctl stop mbgated && " + SMALL_DISK.format(uid=uid, gid=gid, folder=real))
    try:
        mark = plant.mark()
        plant.restart()
        plant.wait_until_served(POLLED)
        with Poller(plant.port, POLLED, 0, VALUE) as poller:
            full = f"test $(df --output=avail {real} | tail -1) -eq 0"
            plant.guest.wait_for(full, "the disk becomes full", 120)
            assert poller.more(20), "the bus does not go on"
        assert not poller.wrong, poller.wrong
        plant.wait_until_served(1)
        lines = plant.journal(mark, "record")
        assert lines and plant.show("NRestarts") == "0", plant.journal(mark)
        return f"{poller.right} right answers and no other; journal: {lines[-1]}"
    finally:
        plant.guest.run(f"systemctl stop mbgated; umount {real}")
        plant.remove_drop_ins()


def read_only_root(plant):
    """The root becomes read-only while it runs: as after errors of the disk, with a journal that cannot be written any
    more, and by mount. It goes on, reloads and starts again."""
    _begin(plant)
    with Poller(plant.port, POLLED, 0, VALUE) as poller:
        try:
            plant.guest.run("echo u >/proc/sysrq-trigger")
            plant.guest.wait_for("! touch /probe 2>/dev/null", "the root is read-only")
            assert poller.more(20), "the bus does not go on"
            plant.guest.run("systemctl reload mbgated")
            assert poller.more(20), "the bus does not go on after a reload"
            plant.guest.run("mount -o remount,rw / && journalctl --relinquish-var && mount -o remount,ro /")
            assert poller.more(20), "the bus does not go on after mount"
            assert not poller.wrong, poller.wrong
            plant.guest.run("systemctl kill -s KILL mbgated")
            _wait_for_restart(plant, 0)
        finally:
            plant.guest.run("mount -o remount,rw / && journalctl --flush")
    return f"{poller.right} right answers and no other; reloaded, and killed and started again, on it"


def realtime(plant):
    """realtime.conf as it is shipped: the policy, the locked memory and the score."""
    _begin(plant)
    plant.guest.run("mkdir -p /etc/systemd/system/mbgated.service.d && "
                    "cp /usr/share/doc/mbgate/examples/realtime.conf /etc/systemd/system/mbgated.service.d/ && "
                    "systemctl daemon-reload && "
                    "sed -i '1i [gateway]\\nlock_memory = true' /etc/mbgate/mbgate.toml")
    try:
        plant.restart()
        plant.wait_until_served(1)
        pid = plant.show("MainPID")
        policies = plant.guest.run(f"for task in /proc/{pid}/task/*; do chrt -p ${{task##*/}}; done")
        fifo = re.findall(r"policy: SCHED_FIFO", policies)
        assert fifo, policies
        priority = re.search(r"priority: (\d+)", policies).group(1)
        memory = dict(re.findall(r"(VmLck|VmRSS):\s+(\d+)", plant.guest.run(f"cat /proc/{pid}/status")))
        assert int(memory["VmLck"]) > 0, "no memory is locked"
        security = plant.guest.run("systemd-analyze security mbgated --no-pager")
        score = re.search(r"exposure level for mbgated.service: ([0-9.]+)", security).group(1)
        tasks = policies.count("current scheduling policy")
        return (f"{len(fifo)} of {tasks} threads SCHED_FIFO {priority}, VmLck {memory['VmLck']} kB "
                f"(VmRSS {memory['VmRSS']} kB), exposure {score}")
    finally:
        plant.remove_drop_ins()
