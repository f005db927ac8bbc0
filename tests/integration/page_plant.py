# SPDX-License-Identifier: Apache-2.0
"""A plant to look at on the status page: mbgated, and an mbgate-sim for each of three lines. The turntable is slow; the lift
has a line of its own, and can be switched off. Clients read all of them, again and again."""

import pathlib
import signal
import threading

from demo_plant import Plant, Process
from fault_plant import Client

# Name, baud rate, parity; then its drives: name, address, unit, model, profile, what else the simulator is told.
LINES = (
    ("line-a", 115200, "none", (("axis-x", 1, 1, "moons", "moons-st", ""), ("feeder", 2, 2, "stepper", "rs485-stepper", ""))),
    ("line-b", 19200, "even", (("turntable", 17, 17, "aic", "autonics-aic", 'processing = "150ms"'),)),
    ("line-c", 38400, "even", (("lift", 5, 5, "moons", "moons-st", ""),)),
)
ABSENT = 31  # a unit that no route leads to
READS = {1: (3, 0x1E, 2), 2: (3, 0xD8, 2), 17: (4, 0x68, 5), 5: (3, 0x1E, 2)}  # unit: function, address, count
PAUSE = 0.1  # seconds between two reads of a client


class Polling:
    """Reads one unit again and again until it is ended; what is answered is not looked at."""

    def __init__(self, port, unit, pause):
        self._client = Client(port)
        self._ended = threading.Event()
        function, address, count = READS.get(unit, (3, 0, 1))
        self._pdu = bytes([function]) + address.to_bytes(2, "big") + count.to_bytes(2, "big")
        self._unit, self._pause = unit, pause
        self._thread = threading.Thread(target=self._poll)
        self._thread.start()

    def _poll(self):
        try:
            while not self._ended.wait(self._pause):
                self._client.ask(self._pdu, self._unit)
        except OSError:
            pass  # the gateway has ended

    def end(self):
        self._ended.set()
        self._thread.join()
        self._client.close()


class PagePlant(Plant):
    """with PagePlant() as plant: plant.url is the page, plant.port that of Modbus clients. `links`: other names for the
    files that are ports of lines."""

    def __init__(self, links=None, keys="", lines=LINES):
        self._lines = lines
        self._links = links or {}
        self._keys = keys
        self._polling = []
        self.simulators = {}  # by line

    def _start(self):
        self.folder = pathlib.Path(self._folder.name)
        self.control = self.folder / "control"
        gateway = f'[http]\nsocket = "{self.control}"\nlisten = ["127.0.0.1:0"]\n{self._keys}\n'
        gateway += '[[listen]]\nname = "plant"\naddress = "127.0.0.1"\nport = 0\n'
        for name, baud, parity, drives in self._lines:
            gateway += self._line(name, f"baud = {baud}\nparity = \"{parity}\"\n", drives)
        (self.folder / "mbgate.toml").write_text(gateway, encoding="utf-8")
        self.gateway = Process(self.folder, "mbgated", "--config", "mbgate.toml")
        self._processes.append(self.gateway)
        # Both are listened on before either is told of; in which order is not promised.
        ports = {}
        while len(ports) < 2:
            found = self.gateway.wait_for(r"^listening (plant|http) 127\.0\.0\.1:(\d+)$")
            ports[found.group(1)] = int(found.group(2))
        self.port = ports["plant"]
        self.url = f"http://127.0.0.1:{ports['http']}/"

    def _line(self, name, pace, drives):
        """Starts its drives; what stands in the gateway's configuration of it."""
        link = self._links.get(name, name)
        simulated = f"[[bus]]\nname = \"{name}\"\nlink = '{link}'\n{pace}"
        gateway = f"[[bus]]\nname = \"{name}\"\ndevice = './{link}'\n{pace}response_timeout = \"1s\"\n"
        for drive, address, unit, model, profile, keys in drives:
            where = f'name = "{drive}"\nbus = "{name}"\naddress = {address}\n'
            simulated += f'[[device]]\n{where}model = "{model}"\n{keys}\n'
            gateway += f'[[device]]\n{where}profile = "{profile}"\n[[route]]\nunit = {unit}\ndevice = "{drive}"\n'
        file = self.folder / f"{name}.toml"
        file.write_text(simulated, encoding="utf-8")
        self.simulators[name] = Process(self.folder, "mbgate-sim", file)
        self._processes.append(self.simulators[name])
        self.simulators[name].wait_for("^ready")
        return gateway

    def poll(self, *units, pause=PAUSE):
        """A client for each of them."""
        self._polling += [Polling(self.port, unit, pause) for unit in units]

    def switch_off(self, line):
        """Its drives say nothing any more."""
        self.simulators[line].signal(signal.SIGSTOP)

    def switch_on(self, line):
        self.simulators[line].signal(signal.SIGCONT)

    def __exit__(self, *_):
        for simulator in self.simulators.values():
            simulator.signal(signal.SIGCONT)
        for polling in self._polling:
            polling.end()
        super().__exit__()
