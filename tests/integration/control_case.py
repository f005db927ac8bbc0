# SPDX-License-Identifier: Apache-2.0
"""The HTTP interface of the demo's gateway, for tests: every answer is held to docs/api.yaml."""

import http.client
import json
import pathlib
import re
import select
import socket
import subprocess
import time
import unittest

import jsonschema
import yaml

from demo_plant import PATIENCE, DemoPlant, program

API = yaml.safe_load((pathlib.Path(__file__).parents[2] / "docs" / "api.yaml").read_text(encoding="utf-8"))
EVENTS = "/api/v1/events"
RELOAD = "/api/v1/reload"
TRACE = "/api/v1/trace"
EVENT_DATA = {
    "journal": "JournalEvent", "lost": "LostEvents", "transaction": "Trace", "frame": "Trace", "heard": "Trace",
}  # fmt: skip
MOONS = 1  # the unit of a drive


def validate(body, schema):
    jsonschema.Draft202012Validator({**schema, "components": API["components"]}).validate(body)


def resolved(node):
    """The node, or what it refers to."""
    while "$ref" in node:
        found = API
        for part in node["$ref"].removeprefix("#/").split("/"):
            found = found[part]
        node = found
    return node


class UnixConnection(http.client.HTTPConnection):
    def __init__(self, path):
        super().__init__("mbgated", timeout=PATIENCE)
        self._path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.settimeout(PATIENCE)
        self.sock.connect(str(self._path))


class EventStream:
    """A connection that reads events. `status` is that of HTTP; with 200 there is a stream."""

    def __init__(self, connection, last=None, path=EVENTS):
        connection.request("GET", path, headers={} if last is None else {"Last-Event-ID": str(last)})
        self._answer = connection.getresponse()
        self.status = self._answer.status
        self.type = self._answer.headers["Content-Type"]
        if self.status != 200:
            self._answer.read()
        connection.close()  # the answer keeps what it reads from

    def next(self):
        """The next event: its fields. None: the stream has ended."""
        fields = {}
        while line := self._answer.readline().decode():
            if line == "\n" and "data" in fields:
                fields["data"] = json.loads(fields["data"])
                validate(fields["data"], {"$ref": f"#/components/schemas/{EVENT_DATA[fields['event']]}"})
                return fields
            name, _, value = line.removesuffix("\n").partition(": ")
            if value:  # else it is a comment, or what ends one
                fields[name] = value
        return None

    def has_ended(self):
        """Does it end, when what was sent before has been read?"""
        limit = time.monotonic() + PATIENCE
        while self._answer.readline():  # a comment comes from time to time
            if time.monotonic() >= limit:
                return False
        return True

    def find(self, pattern):
        """The events from the next one up to the first whose text matches."""
        found = []
        while event := self.next():
            found.append(event)
            if re.search(pattern, event["data"].get("text", "")):
                return found
        raise AssertionError(f"no event matches {pattern!r} of {found}")

    def close(self):
        self._answer.close()


class ControlCase(unittest.TestCase):
    """What tests of the control socket have in common."""

    def setUp(self):
        self.plant = self.enterContext(DemoPlant())

    def ask(self, method, path, connection=None, headers=None):
        """The HTTP status and the JSON, which is as docs/api.yaml says. Without a connection: over the Unix socket."""
        own = None if connection else UnixConnection(self.plant.control)
        connection = connection or own
        self.addCleanup(connection.close)
        connection.request(method, path, headers=headers or {})
        answer = connection.getresponse()
        body = json.loads(answer.read())
        if own:
            own.close()
        described = API["paths"].get(path.partition("?")[0], {})
        if method.lower() in described:
            response = resolved(described[method.lower()]["responses"][str(answer.status)])
            schema = response["content"]["application/json"]["schema"]
        else:
            schema = {"$ref": "#/components/schemas/Error"}
        validate(body, schema)
        return answer.status, body

    def status(self):
        code, body = self.ask("GET", "/api/v1/status")
        self.assertEqual(code, 200)
        return body

    def mbgatectl(self, *arguments):
        command = [program("mbgatectl"), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)

    def follow(self, place, *arguments):
        """mbgatectl events, which reads along: its process, and the first line that it printed."""
        command = [program("mbgatectl"), "events", "--control", str(place), *arguments]
        following = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.enterContext(following)
        self.addCleanup(following.kill)
        limit = time.monotonic() + PATIENCE
        while not select.select([following.stdout], [], [], 0.1)[0]:
            self.assertLess(time.monotonic(), limit, "mbgatectl events prints nothing")
            self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        return following, following.stdout.readline()

    def read(self, unit, address=0):
        return self.mbgatectl("read", "holding", address, "--unit", unit, "--port", self.plant.port)

    def device(self, name):
        return next(device for device in self.status()["devices"] if device["name"] == name)

    def edit(self, before, after):
        text = self.plant.configuration.read_text(encoding="utf-8")
        self.assertIn(before, text)
        self.plant.configuration.write_text(text.replace(before, after), encoding="utf-8")


class HttpCase(ControlCase):
    """What tests of the interface over TCP have in common."""

    def configure(self, *lines):
        """These lines in [http], and no other but for the socket, put into force by a reload."""
        text = self.plant.configuration.read_text(encoding="utf-8")
        head, rest = text.split("[http]\n")
        own = [line for line in rest.splitlines() if line.startswith("socket")]
        self.plant.configuration.write_text("\n".join([f"{head}[http]", *own, *lines, ""]), encoding="utf-8")
        code, body = self.ask("POST", RELOAD)
        self.assertEqual(code, 200, body)

    def listen(self, *lines, host="127.0.0.1", shown="127.0.0.1"):
        """A reload adds an address, which self.address is then."""
        self.configure(f'listen = ["{shown}:0"]', *lines)
        self.address = (host, int(self.plant.wait_for(rf"^listening http {re.escape(shown)}:(\d+)$").group(1)))

    def tcp(self, source=None):
        return http.client.HTTPConnection(*self.address, timeout=PATIENCE, source_address=source and (source, 0))
