# SPDX-License-Identifier: Apache-2.0
"""USB over TCP, the far side: what Linux's vhci_hcd asks of a device goes to a chip, and back comes what that says."""

import asyncio
import struct

SUBMIT, UNLINK, SUBMITTED, UNLINKED = 1, 2, 3, 4
HEADER = struct.Struct(">10I8s")
STALL, RESET = -32, -104  # EPIPE, ECONNRESET
FULL_SPEED = 2

ATTACH = "modprobe vhci_hcd && exec 3<>/dev/tcp/{host}/{port} && echo {slot} 3 {slot} {speed} >{control}/attach"
CONTROL = "/sys/devices/platform/vhci_hcd.0"


def attach_command(host, port, slot):
    """What a shell of the machine has to run so that the device is plugged in there."""
    return ATTACH.format(host=host, port=port, slot=slot, speed=FULL_SPEED, control=CONTROL)


class Socket:
    """One connection of vhci_hcd, which is one time that the device was plugged in. The chip has control(setup, data),
    which returns bytes or None for a stall, and sent(data); it gives what it received with give()."""

    def __init__(self, chip, reader, writer):
        self._chip, self._reader, self._writer = chip, reader, writer
        self._asked = []  # sequence numbers of transfers that wait for data

    async def serve(self):
        try:
            while True:
                await self._take(HEADER.unpack(await self._reader.readexactly(HEADER.size)))
        except (asyncio.IncompleteReadError, OSError):
            self._writer.transport.abort()

    async def _take(self, header):
        command, sequence, _, inward, endpoint, argument, size = header[:7]
        if command == UNLINK:
            found = argument in self._asked
            if found:
                self._asked.remove(argument)
            self._reply(UNLINKED, sequence, RESET if found else 0)
            return
        data = b"" if inward else await self._reader.readexactly(size)
        if endpoint == 0:
            answer = self._chip.control(header[10], data)
            if answer is None:
                self._reply(SUBMITTED, sequence, STALL)
            else:
                self._reply(SUBMITTED, sequence, 0, len(data) or min(len(answer), size), answer[:size])
        elif inward:
            self._asked.append(sequence)
            self._chip.wanted()
        else:
            self._chip.sent(data)
            self._reply(SUBMITTED, sequence, 0, size)

    def _reply(self, command, sequence, status, size=0, data=b""):
        header = struct.pack(">5IiI3I8x", command, sequence, 0, 0, 0, status, size, 0, 0, 0)
        self._writer.write(header + data)

    def is_asked(self):
        return bool(self._asked)

    def give(self, data):
        """The data of the oldest transfer that waits for some."""
        self._reply(SUBMITTED, self._asked.pop(0), 0, len(data), data)

    def close(self):
        self._writer.transport.abort()
