#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The events of the demo's gateway: as its control socket gives them, and as mbgatectl prints them."""

import json
import signal
import sys
import time
import unittest

from control_case import EVENTS, MOONS, ControlCase, EventStream, UnixConnection, validate
from demo_plant import PATIENCE

MOST_STREAMS = 5


class Events(ControlCase):
    def events(self, last=None):
        stream = EventStream(UnixConnection(self.plant.control), last)
        self.addCleanup(stream.close)
        return stream

    def test_events_are_what_the_journal_gets(self):
        self.edit('name = "axis-x"\nbus = "line-a"\naddress = 1\n', 'name = "axis-x"\nbus = "line-a"\naddress = 99\n')
        streams = [self.events(), self.events()]
        self.assertEqual([(stream.status, stream.type) for stream in streams], [(200, "text/event-stream")] * 2)
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        for _ in range(3):
            self.read(MOONS)
        seen = [stream.find("^device axis-x: no valid answer came so far") for stream in streams]
        self.assertEqual(seen[0], seen[1])
        ids = [int(event["id"]) for event in seen[0]]
        self.assertEqual(ids, list(range(ids[0], ids[0] + len(ids))))
        self.assertEqual(seen[0][-1]["data"]["level"], "warning")
        self.assertIn(("info", "reload: done"), [(it["data"]["level"], it["data"]["text"]) for it in seen[0]])

    def test_events_go_on_after_the_last_one(self):
        first = self.events()
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        had = first.find("configuration in force")[-1]
        first.close()
        self.edit("baud = 9600", "baud = 0")
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 422)
        missed = self.events(had["id"]).find("the configuration stays as it is")
        self.assertEqual(int(missed[0]["id"]), int(had["id"]) + 1)
        self.assertRegex(missed[1]["data"]["text"], r"demo\.toml:\d+:\d+: .*baud")
        # All of them: from the first one, and with a number that this process has not reached.
        everything = self.events(0).find("the configuration stays as it is")
        self.assertRegex(everything[0]["data"]["text"], "listening")
        self.assertEqual(self.events(10**15).find("the configuration stays as it is"), everything)
        self.assertEqual(self.events("yesterday").status, 400)

    def test_a_reader_that_comes_back_too_late_hears_how_much_it_has_missed(self):
        start = self.events(0).next()
        text = self.plant.configuration.read_text(encoding="utf-8")
        wrong = "".join(f"nonsense_{at} = 1\n" for at in range(100))  # a line of the journal each
        self.plant.configuration.write_text(text + wrong, encoding="utf-8")
        for _ in range(3):
            self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 422)
        first = int(start["id"])
        stream = self.events(first)
        lost, event = stream.next(), stream.next()
        self.assertEqual((lost["event"], event["event"]), ("lost", "journal"))
        self.assertNotIn("id", lost)
        self.assertEqual(int(event["id"]), first + lost["data"]["lost"] + 1)

    def test_streams_are_limited_and_keep_nobody_from_the_status(self):
        self.edit("[http]\n", f"[http]\nmax_streams = {4 * MOST_STREAMS}\n")
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        streams = [self.events() for _ in range(MOST_STREAMS)]
        self.assertEqual([stream.status for stream in streams], [200] * MOST_STREAMS)
        code, body = self.ask("GET", EVENTS)
        self.assertEqual(code, 503)
        why = "5 readers of this address or user already follow events or the trace; [http] max_streams = 20 allows 5 of each"
        self.assertEqual(body["error"], why)
        refused = self.mbgatectl("events", "--control", self.plant.control)
        self.assertEqual((refused.returncode, refused.stdout), (1, ""))
        self.assertEqual(refused.stderr, f"mbgatectl: {why}\n")
        self.status()
        streams.pop().close()
        limit = time.monotonic() + PATIENCE
        while self.events().status != 200:
            self.assertLess(time.monotonic(), limit, "the place of a stream that has ended is not free")
        # They do not keep the gateway, and end with it.
        self.plant.end_gateway()
        while streams[0].next() is not None:
            pass

    def test_mbgatectl_prints_events_until_a_signal(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(signal=number):
                following, line = self.follow(self.plant.control)
                self.assertRegex(line, r"^\d\d:\d\d:\d\d (notice reload: asked for by|info reload: nothing has changed\n$)")
                following.send_signal(number)
                self.assertEqual(following.wait(PATIENCE), 0)
                self.assertEqual(following.stderr.read(), "")

    def test_mbgatectl_prints_events_as_json_until_the_gateway_ends(self):
        following, line = self.follow(self.plant.control, "--json")
        event = json.loads(line)
        validate(event, {"$ref": "#/components/schemas/JournalEvent"})
        self.assertRegex(event["text"], "^reload: (asked for by the control socket: uid |nothing has changed$)")
        self.plant.end_gateway()
        *others, end = following.stdout
        for other in others:
            validate(json.loads(other), {"$ref": "#/components/schemas/JournalEvent"})
        self.assertIn("mbgated has ended", json.loads(end)["error"])
        self.assertEqual(following.wait(PATIENCE), 1)
        self.assertEqual(following.stderr.read(), "")


if __name__ == "__main__":
    sys.exit(unittest.main())
