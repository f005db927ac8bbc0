# SPDX-License-Identifier: Apache-2.0
"""Checks of what an adapter does. Each returns what was seen, and raises AssertionError if that is wrong."""

from client import read, told, write

# Of TIOCGICOUNT: what the driver counted. Root may open a port that another process has for itself.
COUNTS = ("perl -e 'open(my $port, \"+<\", \"{path}\") or die; my $counts = \"\\0\" x 80; "
          "ioctl($port, 0x545D, $counts) or die; print((unpack(\"i11\", $counts))[8])'")
PARITY_ERRORS_TO_TELL = 8
HELD_UP = "60s"  # a response timeout that is not over before the check is


def hot_plug(plant):
    """Adapters that are plugged in after the start are served by themselves, under the sandbox."""
    guest, adapters = plant.guest, plant.adapters
    assert "ttyUSB" not in guest.run("cat /proc/devices"), "usbserial is loaded before the service was ever started"
    plant.configure()
    plant.restart()
    assert "ttyUSB" in guest.run("cat /proc/devices"), "the unit did not load usbserial"
    before = plant.read(1)
    assert before == "0A", before
    nodes = adapters.plug(plant.a), adapters.plug(plant.b)
    for unit in (1, 11):
        plant.wait_until_served(unit)
    driver = guest.run("basename $(readlink /sys/class/tty/ttyUSB0/device/driver)")
    assert driver == "ftdi_sio", driver
    return (f"usbserial not loaded at boot; 0A before; {nodes[0]} and {nodes[1]} of {driver} opened by their by-id "
            "paths and answered")


def settings(plant):
    """The chips have the rate and the format of the configuration."""
    for adapter in (plant.a, plant.b):
        assert adapter.chip.fits(adapter.line.settings), f"{adapter.chip.settings}, not {adapter.line.settings}"
        assert adapter.line.noise == 0, f"{adapter.line.noise} bytes were sent with other settings"
    first = plant.a.chip.settings, plant.b.chip.settings
    plant.b.line.settings = "38400 8O2"
    plant.configure(line_b='baud = 38400\nparity = "odd"\nstop_bits = 2')
    plant.guest.run("systemctl reload mbgated")
    plant.wait_until_served(11)
    second = plant.b.chip.settings
    plant.b.line.settings = "115200 8N1"
    plant.configure()
    plant.guest.run("systemctl reload mbgated")
    plant.wait_until_served(11)
    return f"the chips were set to {first[0]} and {first[1]}; after a reload to {second}; drives answered at each"


def latency(plant):
    """The latency timer of the chip is set by a process without privileges."""
    set_to = plant.a.chip.latencies
    assert set_to[0] == 16 and plant.a.chip.latency == 1, set_to
    shown = plant.guest.run("cat /sys/bus/usb-serial/devices/ttyUSB0/latency_timer")
    user, capabilities = plant.guest.run(
        "ps -o user= -p $(systemctl show mbgated -P MainPID); "
        "sed -n 's/^CapEff:\\s*//p' /proc/$(systemctl show mbgated -P MainPID)/status").split()
    assert shown == "1" and user not in ("root", "0"), (shown, user)
    return f"{' → '.join(map(str, set_to))} ms at the chip, by user {user} with capabilities {capabilities}"


def parity(plant):
    """Bytes that come with a wrong parity are counted as bad CRCs, and named."""
    mark = plant.mark()
    plant.a.line.hurt = PARITY_ERRORS_TO_TELL
    answers = []
    # On a busy machine an answer may come after its timeout, and a read get 0B without going out.
    while plant.a.line.hurt > 0 and len(answers) < 3 * PARITY_ERRORS_TO_TELL:
        answers.append(plant.read(2))
    assert plant.a.line.hurt == 0, f"{plant.a.line.hurt} answers were not asked for, of {len(answers)} reads"
    assert set(answers) == {"0B"}, answers
    counted = plant.guest.run(COUNTS.format(path=plant.a.path))
    assert int(counted) == PARITY_ERRORS_TO_TELL, f"the driver counted {counted}"
    told_so = plant.journal(mark, "bad CRC")
    assert told_so, plant.journal(mark)
    named = [line.strip() for line in plant.status().splitlines() if line.startswith("  device hurt")]
    assert named, plant.status()
    plant.wait_until_served(2)
    return (f"{PARITY_ERRORS_TO_TELL} answers with one such byte each: the driver counted {counted}, all got 0B; "
            f"journal: {told_so[0]}; status: {named[0]}")


def echo(plant):
    """An adapter that hears itself: compared where the configuration says so, named where it denies it."""
    seen = []
    plant.a.chip.echo = True
    try:
        for setting in ("true", '"auto"', "false"):
            plant.configure(line_a=f"echo = {setting}")
            plant.restart()
            seen.append(f"{setting}: {_heard_with(plant, setting)}")
    finally:
        plant.a.chip.echo = False
    plant.configure()
    plant.restart()
    plant.wait_until_served(1)
    return "; ".join(seen)


def _heard_with(plant, setting):
    client = plant.client()
    try:
        if setting != "false":
            for value in (7, 8):
                assert told(client.ask(1, read(0))).startswith("0302"), "a read failed"
                assert client.ask(1, write(3, value)) == write(3, value), "a write failed"
                assert client.ask(1, read(3)) == b"\x03\x02\x00" + bytes([value]), "another value is read"
        if setting == "true":
            # A drive that does not answer: its echo must not be taken for its answer.
            assert told(client.ask(5, write(3, 1))) == "0B", "an echo was taken for an answer"
            return "reads and writes right, a silent drive's write 0B"
        setting_text = "and `echo` does not say so" if setting == '"auto"' else "but `echo = false` is set"
        words = f"the adapter receives what it sends, {setting_text}"
        for _ in range(20):
            client.ask(1, read(0))
            if words in plant.status():
                break
        assert words in plant.status(), plant.status()
        return "status: " + next(line.strip() for line in plant.status().splitlines() if words in line)
    finally:
        client.close()


def unplug(plant):
    """Pulled out while a write is on the wire: 0B for it, 0A for what waited, long before any timeout."""
    plant.configure(silent=HELD_UP)
    plant.restart()
    plant.wait_until_served(1)
    clients = [plant.client() for _ in range(4)]
    requests = (5, write(1, 7)), (1, read(0)), (1, write(0, 9)), (5, read(0))
    heard = plant.a.line.count(b"\x05\x06")
    numbers = []
    for client, (unit, pdu) in zip(clients, requests):
        numbers.append(client.send(unit, pdu))
        if len(numbers) == 1:
            plant.a.line.wait_for(b"\x05\x06", heard)
    plant.wait_for_waiting("line-a", 3)
    before = len(plant.a.line.heard)
    plant.adapters.unplug(plant.a)
    answers = [told(client.answer(number, 30)) for client, number in zip(clients, numbers)]
    for client in clients:
        client.close()
    assert answers == ["0B", "0A", "0A", "0A"], answers
    assert plant.read(1) == "0A" and plant.read(11).startswith("0302")
    assert len(plant.a.line.heard) == before, "something was sent on"
    plant.adapters.wait_until_gone(plant.a)
    return (f"the write on the wire {answers[0]}, what waited {', '.join(answers[1:])}, with a timeout of {HELD_UP}; "
            "the other line went on")


def other_node(plant):
    """Comes after `unplug`: the adapter gets another device node, and is served by its by-id path all the same."""
    adapters = plant.adapters
    adapters.unplug(plant.b)
    adapters.wait_until_gone(plant.b)
    mark = plant.mark()
    node_b, node_a = adapters.plug(plant.b), adapters.plug(plant.a)
    assert (node_a, node_b) == ("/dev/ttyUSB1", "/dev/ttyUSB0"), (node_a, node_b)
    plant.wait_until_served(1)
    plant.wait_until_served(11)
    for adapter in (plant.a, plant.b):
        assert adapter.chip.fits(adapter.line.settings) and adapter.chip.latency == 1, adapter.chip.settings
    back = plant.journal(mark, "line-a is open|line-b is open")
    assert len(back) == 2, back
    return (f"line-a was ttyUSB0 and is {node_a}, line-b was ttyUSB1 and is {node_b}; settings and latency as before; "
            f"journal: {', '.join(back)}")
