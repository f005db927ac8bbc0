#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Wireshark's decoder as the witness: mbgatectl talks to the demo's gateway through a recorder, and tshark must
find a well-formed Modbus TCP request and its response for everything that was said."""

import pathlib
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading

from demo_plant import PATIENCE, DemoPlant, program

SKIPPED = 77
MODBUS_PORT = 502  # where tshark expects Modbus TCP
LINKTYPE_RAW = 101  # IP without a link layer
COMMANDS = (
    ("write", "holding", "0x1E", "200000", "--type", "i32", "--unit", "1"),
    ("read", "holding", "0x1E", "--type", "i32", "--unit", "1"),
    ("write", "holding", "0x1B", "55", "--unit", "2"),
    ("write", "coils", "3", "on", "--unit", "17"),
    ("read", "coils", "0", "--count", "10", "--unit", "17"),
    ("read", "discrete", "0", "--count", "10", "--unit", "17"),
    ("read", "input", "0x68", "--count", "5", "--unit", "17"),
    ("read", "input", "0x7000", "--unit", "17"),  # exception 02
    ("read", "holding", "0", "--unit", "99"),  # exception 0A
)
# Function, and exception code if any, of each request and response above.
EXPECTED = [
    "16,", "16,", "3,", "3,", "6,", "6,", "5,", "5,", "1,", "1,", "2,", "2,", "4,", "4,", "4,", "4,2", "3,", "3,10",
]  # fmt: skip


class Recording:
    """What two ends of a TCP connection said, as a capture file of IP packets."""

    def __init__(self):
        self.pcap = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, LINKTYPE_RAW)
        self._seconds = 0

    def add(self, ports, sequence, acknowledged, data):
        """A segment from ports[0] to ports[1]. Checksums stay zero: tshark does not look at them."""
        push_and_acknowledge = 0x18
        tcp = struct.pack(">HHIIBBHHH", *ports, sequence, acknowledged, 5 << 4, push_and_acknowledge, 65535, 0, 0)
        size = 20 + len(tcp) + len(data)
        loopback = socket.inet_aton("127.0.0.1")
        ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, size, 0, 0, 64, socket.IPPROTO_TCP, 0, loopback, loopback)
        self._seconds += 1
        self.pcap += struct.pack("<IIII", self._seconds, 0, size, size) + ip + tcp + data


def relay_once(listener, gateway_port, recording, client_port):
    """Carries one connection to the gateway and back, and records each piece."""
    client, _ = listener.accept()
    with client, socket.create_connection(("127.0.0.1", gateway_port), PATIENCE) as gateway:
        client.settimeout(PATIENCE)
        request = client.recv(260)
        gateway.sendall(request)
        response = gateway.recv(260)
        client.sendall(response)
    recording.add((client_port, MODBUS_PORT), 1, 1, request)
    recording.add((MODBUS_PORT, client_port), 1, 1 + len(request), response)


def record(plant):
    recording = Recording()
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(PATIENCE)
        port = listener.getsockname()[1]
        for number, command in enumerate(COMMANDS):
            relay = threading.Thread(target=relay_once, args=(listener, plant.port, recording, 40000 + number))
            relay.start()
            subprocess.run([program("mbgatectl"), *command, "--port", str(port)], timeout=60, check=False)
            relay.join()
    return recording.pcap


def decode(pcap):
    """One line for each ADU that tshark finds, and what it complains about."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "recording.pcap")
        file.write_bytes(pcap)
        fields = ["-T", "fields", "-E", "separator=,", "-e", "modbus.func_code", "-e", "modbus.exception_code"]
        tshark = ["tshark", "-r", str(file)]
        found = subprocess.run([*tshark, "-Y", "mbtcp", *fields], capture_output=True, text=True, check=True)
        complaints = subprocess.run(
            [*tshark, "-Y", "_ws.malformed || _ws.expert.severity >= 6291456"],
            capture_output=True,
            text=True,
            check=True,
        )
    return found.stdout.split(), complaints.stdout


def main():
    if shutil.which("tshark") is None:
        print("skipped: tshark is not installed (./dev test --all installs it)")
        return SKIPPED
    with DemoPlant() as plant:
        pcap = record(plant)
    found, complaints = decode(pcap)
    print("found   ", *found)
    print("expected", *EXPECTED)
    print(complaints, end="")
    return 0 if found == EXPECTED and not complaints else 1


if __name__ == "__main__":
    sys.exit(main())
