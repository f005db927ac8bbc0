#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Drives of four makers on an RTU line, an ASCII line, a serial device server and Ethernet: pymodbus sees six units with
big-endian 32-bit values, whatever each drive speaks."""

import logging
import pathlib
import sys
import tempfile
import unittest

from pymodbus.client import ModbusTcpClient

from demo_plant import Process

SIMULATOR = """
[[bus]]
name = "line-a"
link = "line-a"
baud = 115200
parity = "none"
[[bus]]
name = "line-b"
link = "line-b"
mode = "ascii"
baud = 19200
parity = "even"
[[bus]]
name = "server"
listen = "127.0.0.1:0"
baud = 115200
parity = "none"
[[bus]]
name = "ethernet"
mode = "tcp"
listen = "127.0.0.1:0"
[[device]]
name = "m3"
bus = "line-a"
address = 1
model = "moons"
series = "m3"
word_order = "little"
[[device]]
name = "stepper"
bus = "line-a"
address = 2
model = "stepper"
[[device]]
name = "aic"
bus = "line-a"
address = 17
model = "aic"
response_wait = "20ms"
[[device]]
name = "fda"
bus = "line-b"
address = 5
model = "fda6000"
[[device]]
name = "far"
bus = "server"
address = 3
model = "moons"
series = "st"
word_order = "little"
[[device]]
name = "ip"
bus = "ethernet"
model = "moons"
series = "mdx"
word_order = "little"
"""

GATEWAY = """
[[listen]]
name = "plant"
port = 0
[[bus]]
name = "line-a"
device = "line-a"
baud = 115200
parity = "none"
response_timeout = "2s"
[[bus]]
name = "line-b"
device = "line-b"
mode = "ascii"
baud = 19200
parity = "even"
response_timeout = "2s"
[[bus]]
name = "server"
device = "tcp://127.0.0.1:{server}"
baud = 115200
parity = "none"
response_timeout = "2s"
[[bus]]
name = "ethernet"
mode = "tcp"
host = "127.0.0.1"
port = {ethernet}
response_timeout = "2s"
"""

DRIVES = [
    # unit, bus, address, profile, word order that must be said, a 32-bit value
    (11, "line-a", 1, "moons-m3", "little", 0x016C),
    (12, "line-a", 2, "rs485-stepper", None, 0x00D8),
    (13, "line-a", 17, "autonics-aic", None, 0x0002),
    (14, "line-b", 5, "higen-fda6000", None, None),
    (15, "server", 3, "moons-st", "little", 0x001E),
    (16, "ethernet", 255, "moons-mdx", "little", 0x001E),
]


def drive_text(unit, bus, address, profile, order, _):
    said = f'word_order = "{order}"\n' if order else ""
    wait = 'response_wait = "20ms"\n' if profile == "autonics-aic" else ""
    return (
        f'[[device]]\nname = "unit-{unit}"\nbus = "{bus}"\naddress = {address}\nprofile = "{profile}"\n{said}{wait}'
        f'[[route]]\nunit = {unit}\ndevice = "unit-{unit}"\nword_order = "big"\n'
    )


class FamiliesShowBigEndianValues(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)
        folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        (folder / "sim.toml").write_text(SIMULATOR, encoding="utf-8")
        simulator = Process(folder, "mbgate-sim", "sim.toml")
        cls.addClassCleanup(simulator.end)
        ports = {name: simulator.wait_for(rf"bus {name} 127\.0\.0\.1:(\d+)").group(1) for name in ("server", "ethernet")}
        simulator.wait_for("^ready")
        text = GATEWAY.format(**ports) + "".join(drive_text(*drive) for drive in DRIVES)
        (folder / "mbgate.toml").write_text(text, encoding="utf-8")
        gateway = Process(folder, "mbgated", "--config", "mbgate.toml")
        cls.addClassCleanup(gateway.end)
        port = int(gateway.wait_for(r"listening plant 127\.0\.0\.1:(\d+)$").group(1))
        cls.client = ModbusTcpClient("127.0.0.1", port=port, timeout=20)
        assert cls.client.connect()
        cls.addClassCleanup(cls.client.close)
        for unit, *_ in DRIVES:  # a line listens before it first transmits, which a read may wait for
            answer = cls.client.read_holding_registers(0x0065, count=1, slave=unit)
            assert getattr(answer, "exception_code", 0) != 0x0B, (unit, answer)

    def test_values_are_big_endian_everywhere(self):
        for unit, _, _, _, _, value in DRIVES:
            if value is None:
                continue
            with self.subTest(unit=unit):
                answer = self.client.write_registers(value, [0x0003, 0x0D40], slave=unit)
                self.assertFalse(answer.isError(), answer)
                self.assertEqual(self.client.read_holding_registers(value, count=2, slave=unit).registers, [0x0003, 0x0D40])
                self.assertEqual(self.client.read_holding_registers(value + 1, count=1, slave=unit).registers, [0x0D40])

    def test_the_ascii_drive_has_plain_registers(self):
        self.assertFalse(self.client.write_register(0xC8, 123, slave=14).isError())
        self.assertEqual(self.client.read_holding_registers(0xC8, count=1, slave=14).registers, [123])

    def test_long_reads_are_one_answer(self):
        for unit in (11, 15, 16):
            with self.subTest(unit=unit):
                answer = self.client.read_holding_registers(0, count=125, slave=unit)
                self.assertFalse(answer.isError(), answer)
                self.assertEqual(len(answer.registers), 125)

    def test_exceptions_of_makers_arrive(self):
        self.assertEqual(self.client.write_register(0x04, 1, slave=16).exception_code, 0x12)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
