# SPDX-License-Identifier: Apache-2.0
"""A Modbus TCP server on loopback, which answers each request with what a test says."""

import socket
import threading


class TcpServer:
    """`answer(unit, pdu)` gives the PDU of each answer. Connections come and go as the gateway likes."""

    def __init__(self, answer):
        self._answer = answer
        self._door = socket.create_server(("127.0.0.1", 0))
        self.port = self._door.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def end(self):
        self._door.close()

    def _accept(self):
        while True:
            try:
                connection, _ = self._door.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=[connection], daemon=True).start()

    def _serve(self, connection):
        try:
            with connection, connection.makefile("rb") as stream:
                while len(head := stream.read(7)) == 7:
                    answer = self._answer(head[6], stream.read(int.from_bytes(head[4:6], "big") - 1))
                    connection.sendall(head[:4] + (len(answer) + 1).to_bytes(2, "big") + head[6:] + answer)
        except OSError:
            pass  # the gateway has gone
