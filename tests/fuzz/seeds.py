# SPDX-License-Identifier: Apache-2.0
"""Inputs to begin with: the printed frames of the drives' manuals, our configuration files and profiles."""

import pathlib
import random
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]


def printed_frames():
    """Request and response without CRC, as the manuals print them."""
    requests, pairs = {}, []
    for line in (ROOT / "tests/manuals/rtu.tsv").read_text(encoding="utf-8").splitlines()[1:]:
        manual, number, direction, answers, frame = line.split("\t")
        content = bytes.fromhex(frame)[:-2]
        if direction == "request":
            requests[manual, number] = content
        elif (manual, answers) in requests:
            pairs.append((requests[manual, answers], content))
    return pairs


def crc(data):
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = (value >> 1) ^ 0xA001 if value & 1 else value >> 1
    return value.to_bytes(2, "little")


def ascii_frame(content):
    return b":" + (content + bytes([-sum(content) & 0xFF])).hex().upper().encode() + b"\r\n"


def piece(data):
    return bytes([len(data)]) + data


def framer_script(request, frame):
    """An address, a request, and its answer in two pieces, then silence."""
    cut = len(frame) // 2
    return (request[:1] + piece(request[1:]) + b"\0" + piece(frame[:cut]) + b"\2\0\x14" + b"\0" + piece(frame[cut:]) +
            b"\2\x30\0")


def mbap_stream():
    stream = b"\x07"
    for transaction, (request, _) in enumerate(printed_frames()[:6]):
        stream += transaction.to_bytes(2, "big") + b"\0\0" + len(request).to_bytes(2, "big") + request
    return stream + b"\0\7\0\1\0\6abcdef" + b"\0\0\0\0\0\1"


def texts(folder, rename):
    for file in sorted((ROOT / folder).glob("*.toml")):
        text = re.sub(r"^\s*#.*\n", "", file.read_text(encoding="utf-8"), flags=re.MULTILINE)
        if rename:
            text = re.sub(r'^name = ".*?"', 'name = "fuzz"', text, count=1, flags=re.MULTILINE)
        yield text.encode()


def machine_scripts():
    """A read that is answered, a write, a stop, time, a lost line."""
    ask = bytes([1, 0, 1, 4, 2, 7])
    answer = bytes([9, 0, 0, 3])
    late = bytes([14, 10])
    for choices in range(0, 0x400, 0x55):
        yield (choices.to_bytes(2, "big") + late * 20 + ask + answer + ask + late + answer +
               bytes([1, 1, 1, 4, 2, 2]) + bytes([1, 0, 1, 0, 0, 0]) + answer * 2 + bytes([7, 0, 5, 1, 12, 0]) +
               late * 3 + bytes([15, 0xFF]))


def reloads():
    """Requests on the wire and waiting while settings change, one thing at a time, there and back."""
    read, write, stop = bytes([1, 0, 1, 4, 2, 7]), bytes([1, 1, 1, 4, 2, 2]), bytes([2, 2, 2, 0, 0, 0])
    answer, late = bytes([9, 0, 0, 3]), bytes([14, 10])
    slow, fast = bytes([15, 0xC0]), bytes([15, 0x81])
    for bit in range(-1, 13):
        change = 1 << bit if bit >= 0 else 0

        def reload(change, choices=None):
            other = b"" if choices is None else choices.to_bytes(2, "big")
            return bytes([15, 0x60 if other else 0x40]) + change.to_bytes(2, "big") + other
        for choices in (0, 0x155, 0x3FF):
            yield (choices.to_bytes(2, "big") + late * 20 + read + write + read + reload(change) + answer + stop + write +
                   late + reload(0x4000 | change) + answer * 2 + slow + reload(0) + late + fast +
                   reload(change, choices ^ 0x3FF) + late * 3)


def drive(rules, little, one_memory=0):
    """Values of two and four registers, one of them for motion, small limits and a parameter group."""
    values = [(1, 0, 4, 0), (1, 1, 8, 1), (1, 0, 16, 0), (0, 0, 6, 0)]
    limits = (2, 4, 8, 2, 8)  # holding, input, coils; registers and coils written
    return (bytes([len(values), *sum(values, ())]) + b"".join(word.to_bytes(2, "big") for word in limits) +
            bytes([one_memory, 18, 1, 8, rules, 1 - little]))


def plan_scripts():
    """Reads and writes of values, whole, cut and split, by windows and for all."""
    requests = [request[1:] for request, _ in printed_frames()[::4]]
    requests += [bytes.fromhex(it) for it in (
        "0300030011", "0300050001", "0400040008", "010003000C", "0600050102", "1000040002040102 0304",
        "10000300030601020304 0506", "1000040010201011121314151617 18191A1B1C1D1E1F202122232425262728292A2B2C2D2E2F",
        "160005FFF00003", "1700050001000400020401020304", "0F0003000C0255AA", "050003FF00")]
    window = bytes([2, 0, 0, 0, 0, 0x7F])   # holding registers, seen where they are
    inputs = bytes([2, 1, 0, 4, 0, 0x3F])   # input registers, seen as holding ones
    resolved_route_of = {"plain": bytes([0, 0]), "known": bytes([1, 1, 1, 0]), "windows": bytes([5, 1, 1, 1]) + window,
              "inputs": bytes([1, 1, 1, 1]) + inputs,
              "all": bytes([2, 2, 4, 8]) + bytes([4, 1, 1, 0])}
    for number, request in enumerate(requests):
        for at, way in enumerate(resolved_route_of.values()):
            yield drive((number * 5 + at) % 64, number % 2, at % 2) + way + piece(request) + bytes(8)


def http_requests():
    """What a page, a program and somebody elsewhere ask."""
    for line, *fields in (
            ("GET / HTTP/1.1", "Host: 127.0.0.1:8080"),
            ("HEAD /page/main.js HTTP/1.1", "Host: [::1]", "If-None-Match: \"x\""),
            ("GET /api/v1/trace?bus=line-a&device=axis-x&client=192.0.2.1&function=3&failed=1 HTTP/1.1",
             "Host: localhost"),
            ("GET /api/v1/trace?events=1&failed=%31&bus=%C3%A4 HTTP/1.1", "Host: gateway.plant:80"),
            ("GET /api/v1/events HTTP/1.1", "Host: 192.168.10.2", "Last-Event-ID: 12"),
            ("POST /api/v1/reload HTTP/1.1", "Host: localhost", "Content-Length: 2"),
            ("GET /api/v1/status HTTP/1.1", "Host: 127.0.0.1:8080", "Origin: http://127.0.0.1:8080"),
            ("GET /api/v1/status HTTP/1.0", "Origin: http://elsewhere.example")):
        yield "\r\n".join([line, *fields, "", "{}"]).encode()


def recordings():
    """A read that is answered, with other settings in between; a client with a role; an end."""
    lines = ["mbgate recording 1", "version 0.1.0", "config /etc/mbgate/mbgate.toml"]
    config = ["[[listen]]", 'name = "plant"', "port = 0", 'bus = "line-a"', "[[bus]]", 'name = "line-a"',
              'device = "/dev/ttyS0"', 'listen_first = "0ms"', "echo = false"]
    config = [f"| {line}" for line in config]
    head = [*lines, *config, "500 start", "< open 0", "517 opened 0 virtual", "< report bus line-a is open"]
    asked = ["3000000 connected 1 0 192.0.2.1 0", "3000001 read 1 0 000100000006010300000001", "9000000 time",
             "< look 0", "9000001 looked 0", "< transmit 0 010300000001840A", "19000000 line 0 01030200017984"]
    asked += ["< send 1 0001000000050103020001"]
    ends = ["19000100 sent 1", "19000200 fin 1", "19000300 gone 1", "20000000 looked 0", "21000000 lost 0",
            "22000000 stalled 800", "23000000 clear", "24000000 shutdown", "end no room"]
    yield "\n".join([*head, *asked, ""]).encode()
    yield "\n".join([*head, *asked, *lines[2:], *config, "19000050 settings", *ends, ""]).encode()
    came = ["517 connected 1 0 192.0.2.1 12 role 4F70", "518 connected 2 0 ::1 0 no-role"]
    yield "\n".join([*head, *came, *ends, ""]).encode()


def of(target):
    if target == "http":
        return list(http_requests())
    if target == "recording":
        return list(recordings())
    if target == "mbap":
        return [mbap_stream()]
    if target in ("rtu_framer", "ascii_framer"):
        encode = ascii_frame if target == "ascii_framer" else lambda content: content + crc(content)
        return [framer_script(request, encode(answer)) for request, answer in printed_frames()]
    if target == "plan":
        return list(plan_scripts())
    if target == "config":
        return [*texts("tests/config/valid", False), *texts("tests/config/invalid", False), *texts("conf", False)]
    if target == "rules":
        return [text[text.index(b"[[group]]"):] for folder in ("valid", "invalid")
                for text in texts(f"tests/config/{folder}", False) if b"[[group]]" in text]
    if target == "profile":
        return [*texts("tests/config/profiles", True), *texts("tests/config/profiles-invalid", True),
                *texts("conf/profiles", True)]
    if target == "role":
        return []  # its scripts are short: the corpus does
    if target == "plant":
        return [number.to_bytes(2, "big") + random.Random(number).randbytes(1000) for number in range(60)]
    return [*machine_scripts(), *reloads()]


def write(target, folder):
    for number, seed in enumerate(of(target)):
        (folder / f"seed-{number}").write_bytes(seed)
