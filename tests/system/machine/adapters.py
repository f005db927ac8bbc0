# SPDX-License-Identifier: Apache-2.0
"""The adapters outside of the machine, each with its line, in a thread of their own."""

import asyncio
import threading

from drives import Line
from ftdi import Chip
from guest import HERE_FROM_THERE
from usbip import CONTROL, attach_command

PATIENCE = 60  # seconds; only ends what hangs


class Adapter:
    """A chip and the line behind it, and where it is plugged in."""

    def __init__(self, serial, slot, settings, addresses):
        self.line = Line(settings, addresses)
        self.chip = Chip(serial, self.line)
        self.slot, self.port = slot, 0
        self.path = f"/dev/serial/by-id/usb-FTDI_FT232R_USB_UART_{serial}-if00-port0"


class Adapters:
    """with Adapters(guest, adapter, ...) as adapters: nothing is plugged in at first."""

    def __init__(self, guest, *adapters):
        self._guest, self._adapters = guest, adapters
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)

    def __enter__(self):
        self._thread.start()
        for adapter in self._adapters:
            server = self._do(asyncio.start_server(adapter.chip.plug, "127.0.0.1", 0))
            adapter.port = server.sockets[0].getsockname()[1]
        return self

    def _do(self, what):
        return asyncio.run_coroutine_threadsafe(what, self._loop).result(PATIENCE)

    def plug(self, adapter):
        """Plugs it in; its device node, once udev has made the name by its serial number."""
        self._guest.run(attach_command(HERE_FROM_THERE, adapter.port, adapter.slot))
        return self._guest.wait_for(f"readlink -e {adapter.path}", f"{adapter.path} appears")

    def unplug(self, adapter):
        """Pulls it out, in the midst of whatever is going on."""
        async def pull():
            adapter.chip.plugged.close()
        self._do(pull())

    def wait_until_gone(self, adapter):
        slot = f"^hs *{adapter.slot:04d} *004 "
        self._guest.wait_for(f"! test -e {adapter.path} && grep -q '{slot}' {CONTROL}/status", f"{adapter.path} goes")

    def __exit__(self, *_):
        for adapter in self._adapters:
            if adapter.chip.plugged is not None:
                self.unplug(adapter)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
