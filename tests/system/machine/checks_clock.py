# SPDX-License-Identifier: Apache-2.0
"""The clock is set by an hour while a client polls and writes wait: deadlines and timeouts take no notice of it."""

from client import Poller, read, told, write

HELD_UP = "20s"  # how long the silent drive holds up its line
AT_ONCE = 3  # seconds in which nothing may be answered for the jump alone


def forward(plant):
    """What waits is not over an hour early."""
    return _jump(plant, "+1 hour", _wait_long)


def back(plant):
    """What waits is not over an hour late."""
    return _jump(plant, "-1 hour", _wait_short)


def _jump(plant, distance, wait):
    plant.configure(silent=HELD_UP)
    plant.restart()
    plant.wait_until_served(1)
    plant.wait_until_served(11)
    plant.b.line.registers[1][0] = 4711
    holder, waiting = plant.client(), plant.client()
    heard = plant.a.line.count(b"\x05\x03")
    with Poller(plant.port, 11, 0, 4711) as poller:
        assert poller.more(), "the client that polls gets no answers"
        held = holder.send(5, read(0))
        plant.a.line.wait_for(b"\x05\x03", heard)
        try:
            seen = wait(plant, holder, held, waiting, distance)
            assert poller.more(), f"no more answers on the other line after the jump: {poller.wrong}"
        finally:
            holder.close()
            waiting.close()
    assert not poller.wrong, poller.wrong
    plant.wait_until_served(1)
    state = plant.show("NRestarts"), plant.show("ActiveState")
    assert state == ("0", "active"), state
    return f"{seen}; the client that polls the other line got {poller.right} right answers and no other"


def _set_clock(plant, distance):
    before = int(plant.guest.run("date +%s"))
    plant.guest.run(f"date -s '{distance}'")
    after = int(plant.guest.run("date +%s"))
    assert abs(after - before) > 3000, f"the clock went from {before} to {after}"


def _wait_long(plant, holder, held, waiting, distance):
    """A write with a deadline of two minutes survives the jump, and is carried out once the line is free."""
    value = 0x1234
    sent = waiting.send(1, write(4, value))
    plant.wait_for_waiting("line-a", 1)
    _set_clock(plant, distance)
    early = told(waiting.answer(sent, AT_ONCE)), told(holder.answer(held, 0.1))
    assert early == ("nothing", "nothing"), f"answered for the jump: {early}"
    answers = told(holder.answer(held)), told(waiting.answer(sent))
    assert answers == ("0B", write(4, value).hex()), answers
    count = plant.a.line.count(b"\x01" + write(4, value))
    assert count == 1, f"{count} writes on the wire"
    return "the write that waited was sent once, after the silent drive's timeout, and answered"


def _wait_short(plant, holder, held, waiting, distance):
    """A write with a deadline of eight seconds gets 06 before the line is free, and is never sent."""
    value = 0x4321
    sent = waiting.send(21, write(4, value))
    plant.wait_for_waiting("line-a", 1)
    _set_clock(plant, distance)
    answer = told(waiting.answer(sent))
    assert answer == "06", answer
    assert told(holder.answer(held, 0.1)) == "nothing", "the silent drive's timeout was over first"
    assert told(holder.answer(held)) == "0B"
    plant.wait_until_served(1)
    count = plant.a.line.count(b"\x01" + write(4, value))
    assert count == 0, f"{count} writes on the wire after their deadline"
    return "a write with a deadline of 8 s got 06 while the line was held up, and was never sent"
