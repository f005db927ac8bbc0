#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""ser2net is the serial device server between mbgated and simulated drives: RTU and ASCII over a plain TCP connection.
Skipped where ser2net is not installed."""

import itertools
import os
import pathlib
import shutil
import socket
import sys
import tempfile
import time
import unittest

from demo_plant import PATIENCE, Process

SER2NET = shutil.which("ser2net", path=os.environ.get("PATH", "") + ":/usr/sbin:/usr/local/sbin")
SKIPPED = 77

DRIVE, NOBODY = 1, 9
UNAVAILABLE, NO_RESPONSE = 0x0A, 0x0B
DISTANCE = "001E"  # of a MOONS' drive, two registers

# What a bus is to the simulator and to the gateway, and what its characters are to ser2net.
BUSES = {
    "rtu": ('mode = "rtu"\nbaud = 115200\nparity = "none"\n', "115200n81"),
    "ascii": ('mode = "ascii"\nbaud = 115200\nparity = "even"\ndata_bits = 7\n', "115200e71"),
}


def free_port():
    """ser2net cannot say which port the kernel chose for it, so it is told one that was free a moment ago."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Client:
    """A Modbus TCP client of mbgated: PDUs in hexadecimal go out, PDUs in hexadecimal come back."""

    def __init__(self, port):
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        self._transactions = itertools.cycle(range(0x10000))

    def close(self):
        self._socket.close()

    def ask(self, unit, pdu):
        request = bytes.fromhex(pdu)
        transaction = next(self._transactions).to_bytes(2, "big")
        size = (len(request) + 1).to_bytes(2, "big")
        self._socket.sendall(transaction + b"\0\0" + size + bytes([unit]) + request)
        header = self._receive(7)
        assert header[:4] == transaction + b"\0\0" and header[6] == unit, header.hex()
        return self._receive(int.from_bytes(header[4:6], "big") - 1).hex().upper()

    def _receive(self, size):
        received = b""
        while len(received) < size:
            piece = self._socket.recv(size - len(received))
            assert piece, "the gateway has closed the connection"
            received += piece
        return received


class Plant:
    """mbgate-sim behind ser2net behind mbgated, which has a transparent listener for each bus."""

    def __init__(self, folder):
        self._folder = pathlib.Path(folder)
        self._ports = {name: free_port() for name in BUSES}
        self._processes = []

    def start(self):
        self._start("mbgate-sim", self._write("sim.toml", self._simulated())).wait_for("^ready")
        self.start_ser2net()
        self.gateway = self._start("mbgated", "--config", self._write("mbgate.toml", self._configured()))
        self.listening = {
            name: int(self.gateway.wait_for(rf"listening {name} 127\.0\.0\.1:(\d+)$").group(1)) for name in BUSES
        }

    def start_ser2net(self):
        configuration = self._write("ser2net.yaml", self._served())
        self._ser2net = self._start(SER2NET, "-n", "-d", "-u", "-c", configuration)

    def end_ser2net(self):
        self._processes.remove(self._ser2net)
        self._ser2net.end()

    def end(self):
        for process in reversed(self._processes):
            process.end()

    def _start(self, name, *arguments):
        process = Process(self._folder, name, *arguments)
        self._processes.append(process)
        return process

    def _write(self, name, text):
        path = self._folder / name
        path.write_text(text, encoding="utf-8")
        return path

    @staticmethod
    def _simulated():
        return "".join(
            f'[[bus]]\nname = "{name}"\nlink = "{name}"\n{line}'
            f'[[device]]\nname = "drive-{name}"\nbus = "{name}"\naddress = {DRIVE}\nmodel = "moons"\n'
            for name, (line, _) in BUSES.items()
        )

    def _served(self):
        return "%YAML 1.1\n---\n" + "".join(
            f"connection: &{name}\n"
            f"  accepter: tcp,127.0.0.1,{self._ports[name]}\n"
            f"  connector: serialdev,{self._folder / name},{characters},local\n"
            for name, (_, characters) in BUSES.items()
        )

    def _configured(self):
        return "".join(
            f'[[listen]]\nname = "{name}"\nport = 0\nbus = "{name}"\n'
            f'[[bus]]\nname = "{name}"\ndevice = "tcp://127.0.0.1:{self._ports[name]}"\n{line}'
            'listen_first = "0ms"\nresponse_timeout = "2s"\n'
            for name, (line, _) in BUSES.items()
        )


class ASerialDeviceServer(unittest.TestCase):
    def setUp(self):
        self.plant = Plant(self.enterContext(tempfile.TemporaryDirectory()))
        self.addCleanup(self.plant.end)
        self.plant.start()

    def each_bus(self):
        """A client of each bus, once its drive answers."""
        for name in BUSES:
            with self.subTest(bus=name):
                client = Client(self.plant.listening[name])
                self.addCleanup(client.close)
                self.wait_for_service(client)
                yield name, client

    def wait_for_service(self, client):
        end = time.monotonic() + PATIENCE
        answer = ""
        while time.monotonic() < end:
            answer = client.ask(DRIVE, f"03 {DISTANCE} 0001")
            if answer.startswith("03"):
                return
            self.assertIn(answer, ("830A", "830B"))
            time.sleep(0.05)
        self.fail(f"no service: {answer}")

    def test_carries_reads_and_writes(self):
        for _, client in self.each_bus():
            self.assertEqual(client.ask(DRIVE, f"10 {DISTANCE} 0002 04 0003 0D40"), f"10{DISTANCE}0002")
            self.assertEqual(client.ask(DRIVE, f"03 {DISTANCE} 0002"), "030400030D40")
            self.assertEqual(client.ask(DRIVE, f"06 {DISTANCE} FFFC"), f"06{DISTANCE}FFFC")
            self.assertEqual(client.ask(DRIVE, f"03 {DISTANCE} 0002"), "0304FFFC0D40")
            longest = client.ask(DRIVE, "03 0000 0032")
            self.assertEqual((longest[:4], len(longest)), ("0364", 2 * 102))

    def test_carries_the_drives_exceptions(self):
        for _, client in self.each_bus():
            self.assertEqual(client.ask(DRIVE, "03 7000 0001"), "8302")

    def test_tells_silence_from_an_answer(self):
        for _, client in self.each_bus():
            self.assertEqual(client.ask(NOBODY, f"03 {DISTANCE} 0001"), "830B")
            self.assertEqual(client.ask(DRIVE, f"06 {DISTANCE} 0007"), f"06{DISTANCE}0007")

    def test_serves_again_when_the_device_server_is_back(self):
        clients = dict(self.each_bus())
        self.plant.end_ser2net()
        for client in clients.values():  # a closed connection is opened again when a request needs it
            self.assertIn(client.ask(DRIVE, f"03 {DISTANCE} 0001"), ("830A", "830B"))
        refused = set()
        while refused != set(BUSES):
            line = self.plant.gateway.wait_for(r"bus (\w+): cannot connect to tcp://127\.0\.0\.1:\d+: Connection refused$")
            refused.add(line.group(1))
        for client in clients.values():
            self.assertEqual(client.ask(DRIVE, f"06 {DISTANCE} 0008"), "860A")
        self.plant.start_ser2net()
        for client in clients.values():
            self.wait_for_service(client)
            self.assertEqual(client.ask(DRIVE, f"06 {DISTANCE} 0009"), f"06{DISTANCE}0009")


if __name__ == "__main__":
    if SER2NET is None:
        print("skipped: ser2net is not installed")
        sys.exit(SKIPPED)
    sys.exit(unittest.main(verbosity=2))
