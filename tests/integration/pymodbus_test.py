#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""pymodbus as the client of the demo's gateway: every drive is written and read, by every function it has."""

import sys
import unittest

from pymodbus.client import ModbusTcpClient

from demo_plant import DemoPlant
from either_pymodbus import device_information

MOONS_BIG, STEPPER, MOONS_LITTLE, AIC = 1, 2, 3, 17
STEPPER_AS_IT_IS = 102  # through the bus, without exchange
BROADCAST, NOBODY, GATEWAY = 0, 99, 255
DISTANCE = 0x1E  # of the MOONS' drives, 32 bits
ACCELERATION = 0x1B  # of the MOONS' drives; the stepper has an input delay there
SPEED = 0xD8  # of the stepper, 32 bits


class PymodbusReadsAndWrites(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.plant = cls.enterClassContext(DemoPlant())

    def setUp(self):
        self.client = ModbusTcpClient("127.0.0.1", port=self.plant.port, timeout=10)
        self.assertTrue(self.client.connect())
        self.addCleanup(self.client.close)

    def holding(self, unit, address, count):
        return self.client.read_holding_registers(address, count=count, slave=unit).registers

    def test_a_moons_drive_has_the_high_word_first(self):
        answer = self.client.write_registers(DISTANCE, [0x0003, 0x0D40], slave=MOONS_BIG)
        self.assertFalse(answer.isError(), answer)
        self.assertEqual(self.holding(MOONS_BIG, DISTANCE, 2), [0x0003, 0x0D40])

    def test_a_moons_drive_takes_a_single_register(self):
        answer = self.client.write_register(ACCELERATION, 77, slave=MOONS_BIG)
        self.assertFalse(answer.isError(), answer)
        self.assertEqual(self.holding(MOONS_BIG, ACCELERATION, 1), [77])

    def test_the_other_moons_drive_shows_it_first_too(self):
        answer = self.client.write_registers(DISTANCE, [0xFFFF, 0x3CB0], slave=MOONS_LITTLE)
        self.assertFalse(answer.isError(), answer)
        self.assertEqual(self.holding(MOONS_LITTLE, DISTANCE, 2), [0xFFFF, 0x3CB0])

    def test_the_stepper_has_the_low_word_first_and_does_not_show_it(self):
        answer = self.client.write_registers(SPEED, [0, 12345], slave=STEPPER)
        self.assertFalse(answer.isError(), answer)
        self.assertEqual(self.holding(STEPPER, SPEED, 2), [0, 12345])
        self.assertEqual(self.holding(STEPPER_AS_IT_IS, SPEED, 2), [12345, 0])

    def test_the_aic_takes_coils_and_shows_inputs(self):
        answer = self.client.write_coil(4, True, slave=AIC)
        self.assertFalse(answer.isError(), answer)
        self.assertEqual(self.client.read_coils(4, count=2, slave=AIC).bits[:2], [True, False])
        self.client.write_coil(4, False, slave=AIC)
        self.assertEqual(self.client.read_coils(4, count=1, slave=AIC).bits[0], False)
        self.assertFalse(self.client.read_discrete_inputs(0, count=8, slave=AIC).isError())
        name = self.client.read_input_registers(0x68, count=5, slave=AIC).registers
        self.assertEqual(b"".join(word.to_bytes(2, "big") for word in name), b"AiC-D-56LA")

    def test_a_broadcast_reaches_every_drive_of_its_line(self):
        answer = self.client.write_register(ACCELERATION, 91, slave=BROADCAST)
        self.assertFalse(answer.isError(), answer)
        self.assertEqual(self.holding(MOONS_BIG, ACCELERATION, 1), [91])
        self.assertEqual(self.holding(STEPPER, ACCELERATION, 1), [91])

    def test_exceptions_of_drives_arrive_unchanged(self):
        answer = self.client.write_register(0x04, 1, slave=MOONS_BIG)  # can only be read
        self.assertEqual(answer.exception_code, 0x12)
        answer = self.client.read_input_registers(0x7000, count=1, slave=AIC)
        self.assertEqual(answer.exception_code, 0x02)

    def test_the_gateway_says_that_nobody_is_there(self):
        self.assertEqual(self.client.read_holding_registers(0, count=1, slave=NOBODY).exception_code, 0x0A)

    def test_the_gateway_says_what_it_is(self):
        answer = device_information(self.client, GATEWAY)
        self.assertFalse(answer.isError(), answer)
        self.assertEqual(sorted(answer.information), [0, 1, 2])
        self.assertEqual(self.client.read_input_registers(1, count=2, slave=GATEWAY).registers, [2, 4])


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
