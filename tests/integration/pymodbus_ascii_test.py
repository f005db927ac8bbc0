#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""pymodbus as the device of a line in ASCII mode, and as the client of the gateway in front of it. Its framer shares no
code with the gateway's."""

import os
import pathlib
import sys
import tempfile
import threading
import tty
import unittest

from pymodbus.client import ModbusTcpClient
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext

from demo_plant import Process
from either_pymodbus import AsciiServer

DEVICE = 7
VALUES = 40  # the first of the registers that the device has as 32-bit values, low word first

CONFIGURATION = """
[[listen]]
name = "plant"
address = "127.0.0.1"
port = 0

[[bus]]
name = "line"
device = "{port}"
mode = "ascii"
baud = 115200
data_bits = {data_bits}
parity = "even"
response_timeout = "5s"
listen_first = "0ms"

[[device]]
name = "converter"
bus = "line"
address = 7
word_order = "little"
values32 = {{ holding = [40] }}

[[route]]
unit = 7
device = "converter"
word_order = "big"
"""


class AsciiDevice:
    """One device at the far end of a pseudo terminal."""

    def __init__(self):
        self._line, near = os.openpty()
        tty.setraw(near)
        self.port = os.ttyname(near)
        self._near = near
        block = ModbusSequentialDataBlock(1, [0] * 200)  # the context adds 1 to the addresses of requests
        self.registers = ModbusSlaveContext(hr=block)
        context = ModbusServerContext(slaves={DEVICE: self.registers}, single=False)
        self._server = AsciiServer(context, DEVICE)
        self.heard = b""
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self):
        while data := os.read(self._line, 1024):
            if b"!" in data:
                return
            self.heard += data
            for answer in self._server.answers(data):
                os.write(self._line, answer)

    def end(self):
        os.write(self._near, b"!")  # no character of a frame
        self._thread.join()
        os.close(self._near)
        os.close(self._line)


class PymodbusAnswersInAscii(unittest.TestCase):
    def plant(self, data_bits):
        device = AsciiDevice()
        self.addCleanup(device.end)
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        configuration = folder / "ascii.toml"
        configuration.write_text(CONFIGURATION.format(port=device.port, data_bits=data_bits), encoding="utf-8")
        gateway = Process(folder, "mbgated", "--config", configuration)
        self.addCleanup(gateway.end)
        port = int(gateway.wait_for(r"listening plant 127\.0\.0\.1:(\d+)$").group(1))
        client = ModbusTcpClient("127.0.0.1", port=port, timeout=10)
        self.assertTrue(client.connect())
        self.addCleanup(client.close)
        # A device that was never heard acknowledges no function 6 while the line may still have an echo.
        self.assertFalse(client.read_holding_registers(0, count=1, slave=DEVICE).isError())
        return device, client

    def exchange(self, data_bits):
        device, client = self.plant(data_bits)
        self.assertFalse(client.write_register(3, 0xBEEF, slave=DEVICE).isError())
        self.assertIn(b":07060003BEEF43\r\n", device.heard)
        self.assertEqual(client.read_holding_registers(2, count=2, slave=DEVICE).registers, [0, 0xBEEF])
        self.assertFalse(client.write_registers(VALUES, [0x0003, 0x0D40], slave=DEVICE).isError())
        self.assertEqual(device.registers.getValues(3, VALUES, 2), [0x0D40, 0x0003])
        self.assertEqual(client.read_holding_registers(VALUES, count=2, slave=DEVICE).registers, [0x0003, 0x0D40])
        long = client.read_holding_registers(0, count=125, slave=DEVICE)
        self.assertEqual(len(long.registers), 125)
        self.assertEqual(client.read_holding_registers(1000, count=1, slave=DEVICE).exception_code, 2)

    def test_with_seven_data_bits(self):
        self.exchange(7)

    def test_with_eight_data_bits(self):
        self.exchange(8)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
