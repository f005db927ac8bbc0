#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl and a server that is no mbgated, or not ours any more: what it sends cannot control the terminal. It gives the
answers of a real gateway with escape sequences in each text, by which a terminal would change its title, hide lines, or
type an answer of its own into the shell."""

import json
import re
import socketserver
import threading
import unittest

from control_case import EVENTS, TRACE, ControlCase, EventStream, UnixConnection

STATUS = "/api/v1/status"
# Title, answerback, colour by C0; colour by C1; erased; overtyped; a line that seems to be mbgatectl's; and its text reversed.
SEQUENCES = "\x1b]0;owned\x07\x1b[c\x1b[8m\x9b31m\x7f\b\r\u202e"
LINE = "\nmbgatectl: all is well"
# Control characters of both kinds, what turns text round, and what was no UTF-8 (surrogateescape).
CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\udc80-\udcff]")
# Texts that mbgatectl has to understand.
UNDERSTOOD = {"at", "ended_at", "bytes", "framing", "outcome", "response", "code"}


def poisoned(node, sequences, key=None):
    if isinstance(node, dict):
        return {name: poisoned(value, sequences, name) for name, value in node.items()}
    if isinstance(node, list):
        return [poisoned(value, sequences, key) for value in node]
    return node + sequences if isinstance(node, str) and key not in UNDERSTOOD else node


class Server(socketserver.ThreadingUnixStreamServer):
    """Gives these answers, by method and path: the status of HTTP and a body."""

    daemon_threads = True

    def __init__(self, path, answers):
        super().__init__(str(path), Handler)
        self.answers = answers
        threading.Thread(target=self.serve_forever, daemon=True).start()


class Handler(socketserver.StreamRequestHandler):
    def handle(self):
        method, path, _ = self.rfile.readline().decode().split()
        while self.rfile.readline().strip():
            pass
        status, body = self.server.answers[f"{method} {path}"]
        if isinstance(body, dict):
            body = json.dumps(body)
        body = body.encode("utf-8", "surrogateescape")
        self.wfile.write(f"HTTP/1.1 {status} Said\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body)


class HostileServer(ControlCase):
    def serve(self, answers):
        path = self.plant.control.with_name("hostile")
        server = Server(path, answers)
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        self.place = path

    def printed(self, *arguments):
        """What it prints, which controls no terminal."""
        run = self.mbgatectl(*arguments, "--control", self.place)
        text = run.stdout + run.stderr
        self.assertNotEqual(text, "")
        self.assertIsNone(CONTROLS.search(text), ascii(text))
        return text

    def record(self, path, ask):
        """The first event of a stream, as its name and its data."""
        stream = EventStream(UnixConnection(self.plant.control), path=path)
        self.addCleanup(stream.close)
        ask()
        event = stream.next()
        return event["event"], event["data"]

    def event(self, name, data):
        return 200, f"event: {name}\ndata: {json.dumps(data, ensure_ascii=False)}\n\n"

    def test_status(self):
        self.read(1)
        status = self.status()
        status["clients"].append({"address": "192.0.2.1", "listener": "x", "requests": 1, "outstanding": 0, "refused": 0})
        status["diagnoses"].append({"subject": "bus", "finding": "f", "evidence": "e", "look_at": "l"})
        status["devices"][0]["exceptions"] = {"02" + SEQUENCES + LINE: 1}
        status = poisoned(status, SEQUENCES + LINE)
        self.serve({f"GET {STATUS}": (200, status)})
        text = self.printed("status")
        self.assertRegex(text, r"axis-x\\u001B\]0;owned\\u0007\\u001B\[c\\u001B\[8m\\u009B31m\\u007F\\u0008\\u000D\\u202E"
                               r"\\u000Ambgatectl: all is well")
        self.assertNotRegex(text, "(?m)^mbgatectl: all is well")
        self.assertEqual(json.loads(self.printed("status", "--json")), status, "as JSON it is what was sent")

    def test_an_error(self):
        self.serve({f"GET {STATUS}": (503, {"error": "no" + SEQUENCES + LINE}),
                    "POST /api/v1/reload": (500, {"error": "no" + SEQUENCES + LINE}),
                    f"GET {EVENTS}": (503, {"error": "no" + SEQUENCES + LINE}),
                    f"GET {TRACE}": (503, {"error": "no" + SEQUENCES + LINE})})
        for arguments in (["status"], ["reload"], ["events"], ["trace"]):
            self.assertNotRegex(self.printed(*arguments), "(?m)^mbgatectl: all is well")
        for arguments in (["status"], ["events"], ["trace"]):
            self.assertEqual(list(json.loads(self.printed(*arguments, "--json"))), ["error"])

    def test_reasons_of_a_refused_reload(self):
        """They have lines of their own."""
        message = "file.toml:1:1: error: baud\nbaud = 0\n       ^"
        self.serve({"POST /api/v1/reload": (422, {"messages": [message, SEQUENCES]})})
        self.assertIn(message + "\n\\u001B", self.printed("reload"))

    def test_events(self):
        event = self.record(EVENTS, lambda: self.ask("POST", "/api/v1/reload"))
        poison = {**poisoned(event[1], SEQUENCES + LINE), "level": "info"}
        self.serve({f"GET {EVENTS}": self.event(event[0], poison)})
        self.assertNotRegex(self.printed("events"), "(?m)^mbgatectl: all is well")
        self.assertEqual(json.loads(self.printed("events", "--json").splitlines()[0]), poison)

    def test_events_that_are_none(self):
        for data in (SEQUENCES, "\udc9b31m", f'{{"at":"{SEQUENCES}"}}', '{"at":"2026-11-24T22:10:00.123Z","level":"\udc9b"}',
                     json.dumps({"at": SEQUENCES, "level": "x", "text": "y"})):
            with self.subTest(ascii(data)):
                self.serve({f"GET {EVENTS}": (200, f"event: journal\ndata: {data}\n\n")})
                self.printed("events")
                self.printed("events", "--json")
                self.place.unlink()

    def test_trace(self):
        name, data = self.record(TRACE, lambda: self.read(1))
        poison = poisoned(data, SEQUENCES + LINE)
        self.serve({f"GET {TRACE}": self.event(name, poison)})
        self.assertNotRegex(self.printed("trace"), "(?m)^mbgatectl: all is well")
        record = json.loads(self.printed("trace", "--json").splitlines()[0])
        self.assertEqual(record, {"event": name, **poison})

    def test_a_trace_that_is_none(self):
        name, data = self.record(TRACE, lambda: self.read(1))
        for key in ("framing", "outcome", "ended_at", "response"):
            broken = json.loads(json.dumps(data))
            broken["wire"][0][key] = SEQUENCES
            self.serve({f"GET {TRACE}": self.event(name + SEQUENCES.replace("\r", ""), broken)})
            self.printed("trace")
            self.printed("trace", "--json")
            self.place.unlink()


if __name__ == "__main__":
    unittest.main()
