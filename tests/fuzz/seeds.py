# SPDX-License-Identifier: Apache-2.0
"""Inputs to begin with: the printed frames of the drives' manuals, our configuration files and profiles."""

import pathlib
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


def of(target):
    if target == "mbap":
        return [mbap_stream()]
    if target in ("rtu_framer", "ascii_framer"):
        encode = ascii_frame if target == "ascii_framer" else lambda content: content + crc(content)
        return [framer_script(request, encode(answer)) for request, answer in printed_frames()]
    if target == "plan":
        # No values, no groups, a known device, then the request.
        return [bytes(17) + bytes([known]) + bytes(1 + known) + piece(request[1:]) + bytes(8)
                for request, _ in printed_frames() for known in (0, 1)]
    if target == "config":
        return [*texts("tests/config/valid", False), *texts("tests/config/invalid", False), *texts("conf", False)]
    if target == "profile":
        return [*texts("tests/config/profiles", True), *texts("tests/config/profiles-invalid", True),
                *texts("conf/profiles", True)]
    return list(machine_scripts())


def write(target, folder):
    for number, seed in enumerate(of(target)):
        (folder / f"seed-{number}").write_bytes(seed)
