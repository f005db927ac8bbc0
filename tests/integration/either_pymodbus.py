# SPDX-License-Identifier: Apache-2.0
"""What Debian 12's pymodbus (3.0) and Debian 13's (3.8) name differently."""

import asyncio

try:
    from pymodbus.framer import FramerAscii
    from pymodbus.pdu import DecodePDU
    from pymodbus.pdu.mei_message import ReadDeviceInformationRequest

    class AsciiServer:
        """Frames in, frames out: the answers of `context` to requests for `unit`."""

        def __init__(self, context, unit):
            self._context, self._unit = context, unit
            self._framer = FramerAscii(DecodePDU(True))
            self._unread = b""

        def answers(self, data):
            self._unread += data
            while True:
                used, request = self._framer.processIncomingFrame(self._unread)
                self._unread = self._unread[used:]
                if request is None:
                    return
                if request.dev_id == self._unit:
                    response = asyncio.run(request.update_datastore(self._context[self._unit]))
                    response.dev_id, response.transaction_id = request.dev_id, request.transaction_id
                    yield self._framer.buildFrame(response)

    def device_information(client, unit):
        """43/14, the basic objects."""
        return client.execute(False, ReadDeviceInformationRequest(0x01, 0x00, dev_id=unit))

except ImportError:
    from pymodbus.factory import ServerDecoder
    from pymodbus.mei_message import ReadDeviceInformationRequest
    from pymodbus.transaction import ModbusAsciiFramer

    class AsciiServer:
        """Frames in, frames out: the answers of `context` to requests for `unit`."""

        def __init__(self, context, unit):
            self._context, self._unit = context, unit
            self._framer = ModbusAsciiFramer(ServerDecoder())

        def answers(self, data):
            requests = []
            self._framer.processIncomingPacket(data, requests.append, [self._unit])
            for request in requests:
                response = request.execute(self._context[request.unit_id])
                response.unit_id, response.transaction_id = request.unit_id, request.transaction_id
                yield self._framer.buildPacket(response)

    def device_information(client, unit):
        """43/14, the basic objects."""
        return client.execute(ReadDeviceInformationRequest(0x01, 0x00, unit=unit))
