# SPDX-License-Identifier: Apache-2.0
"""`systemctl restart` under load: what becomes of each request, and how long nobody is served."""

import statistics
import time

from container import eventually
from drive import Line
from load import Worker
from plant import PORT

RESTARTS = 20
LISTEN_FIRST = 0.3  # seconds, as configured below
LINES = (("line-a", 1502, 1), ("line-b", 1504, 2))  # bus, port of its transparent listener, unit


def configuration():
    text = f'[[listen]]\nname = "plant"\naddress = "127.0.0.1"\nport = {PORT}\nallow = ["127.0.0.0/8"]\n'
    for bus, port, unit in LINES:
        text += f"""
[[listen]]
name = "at-{bus}"
address = "127.0.0.1"
port = {port}
bus = "{bus}"

[[bus]]
name = "{bus}"
device = "/run/drives/witness-{bus}"
baud = 115200
parity = "none"
response_timeout = "300ms"
echo = false  # else a write that is the first request after a restart gets 0B: what came may be its echo
listen_first = "{LISTEN_FIRST * 1000:.0f}ms"

[[route]]
unit = {unit}
bus = "{bus}"
address = {unit}
"""
    return text


def under_load(plant):
    plant.fresh()
    lines = {bus: Line(plant.container, f"/run/drives/witness-{bus}", 0.01) for bus, _, _ in LINES}
    for line in lines.values():
        plant.open_to_dialout(line.terminal)
        line.start()
    plant.configure(configuration())
    plant.start()
    workers = []
    for number in range(12):  # a third of them through the socket unit, the others through listeners of its own
        bus, port, unit = LINES[number % 2]
        workers.append(Worker(PORT if number % 3 == 0 else port, unit, number))
        workers[-1].bus = bus
        workers[-1].start()
    eventually(lambda: all(len(worker.good) > 20 for worker in workers))
    moments = []
    for _ in range(RESTARTS):
        begin = time.monotonic()
        took = plant.restart()
        ended = time.monotonic()
        eventually(lambda: all(worker.good[-1] > ended for worker in workers), 20)
        moments.append((begin, took))
        time.sleep(0.5)
    for worker in workers:
        worker.end()
    judge(plant, workers, lines, moments)
    for line in lines.values():
        line.end()


def judge(plant, workers, lines, moments):
    report = plant.report
    wrong = [it for worker in workers for it in worker.wrong]
    total = sum(len(worker.good) for worker in workers)
    report.check(f"{RESTARTS} restarts under load of {len(workers)} clients: no wrong answer", total and not wrong,
                 f"{total} good answers; {wrong[:5] or 'none wrong'}")
    count, faults = writes(workers, lines)
    report.check("each write was seen once if answered, never if refused by 06, at most once otherwise", not faults,
                 f"{count}; {faults[:5] or 'no fault'}")
    finished = [it for it in faults if "answered" in it]
    unknown = sum(len(worker.unknown) for worker in workers)
    on_the_wire = seen_without_answer(workers, lines)
    report.check("what was on the wire was finished: no 0B, and no write on the wire without its answer",
                 not finished and unknown == on_the_wire == 0,
                 f"{unknown} times 0B; {count['connection gone']} writes that came when the connection was closed,"
                 f" {on_the_wire} of them on the wire")
    codes = {}
    for worker in workers:
        for code, number in worker.codes.items():
            codes[f"{code:02X}"] = codes.get(f"{code:02X}", 0) + number
    report.check("what waited was answered 06", set(codes) == {"06"}, f"exceptions {codes}")
    refused = sum(worker.connection_refused for worker in workers)
    report.check("no client was refused a connection", refused == 0, f"{refused} refused")
    times(report, workers, moments)


def writes(workers, lines):
    """What became of all writes, and where what clients were told is not what the drive has seen."""
    count = {"answered": 0, "06": 0, "0B": 0, "connection gone": 0}
    faults = []
    for worker in workers:
        seen = lines[worker.bus].writes.get((worker.unit, worker.register), [])
        where = f"register {worker.register}"
        if seen != sorted(set(seen)):
            faults.append(f"{where}: a value twice or out of order")
        faults += [f"{where}: {value} was answered and not seen" for value in set(worker.done) - set(seen)]
        faults += [f"{where}: {value} was refused and seen" for value in set(worker.refused) & set(seen)]
        told = set(worker.done) | set(worker.refused) | set(worker.unknown) | set(worker.lost)
        faults += [f"{where}: {value} was never written" for value in set(seen) - told]
        for word, values in zip(count, (worker.done, worker.refused, worker.unknown, worker.lost)):
            count[word] += len(values)
    return count, faults


def seen_without_answer(workers, lines):
    """How many writes the drives have got whose clients do not know it."""
    return sum(
        len(set(worker.unknown + worker.lost) & set(lines[worker.bus].writes.get((worker.unit, worker.register), [])))
        for worker in workers
    )


def longest_gap(instants, begin, end):
    """The longest time between two instants that overlaps begin to end."""
    around = [it for it in instants if begin - 1 < it < end]
    return max((after - before for before, after in zip(around, around[1:]) if after > begin), default=end - begin)


def times(report, workers, moments):
    """Time without service: from one good answer of anybody to the next; and that of the client served last."""
    ends = [begin for begin, _ in moments[1:]] + [moments[-1][0] + 20]
    anybody = sorted(it for worker in workers for it in worker.good)
    spans = [(begin, end) for (begin, _), end in zip(moments, ends)]
    service = sorted(longest_gap(anybody, *span) for span in spans)
    clients = sorted(max(longest_gap(worker.good, *span) for worker in workers) for span in spans)
    commands = sorted(took for _, took in moments)
    p50, worst = statistics.median(service), service[-1]
    report.check(
        "time without service: p50 at most 0.3 s + listen_first, worst 2.5 s + listen_first",
        p50 <= 0.3 + LISTEN_FIRST and worst <= 2.5 + LISTEN_FIRST,
        f"p50 {p50:.2f} s, worst {worst:.2f} s of {len(service)} restarts (listen_first {LISTEN_FIRST} s)",
    )
    p50, worst = statistics.median(clients), clients[-1]
    report.check(
        "until every client has had an answer again: worst at most 2.5 s + listen_first",
        worst <= 2.5 + LISTEN_FIRST,
        f"p50 {p50:.2f} s, worst {worst:.2f} s",
    )
    report.told("systemctl restart took", f"p50 {statistics.median(commands):.2f} s, worst {commands[-1]:.2f} s")
