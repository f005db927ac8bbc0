#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The trace of the demo's gateway, as its control socket gives it."""

import datetime
import sys
import time
import unittest

from control_case import EVENTS, MOONS, TRACE, ControlCase, EventStream, UnixConnection
from demo_plant import PATIENCE

AIC = 17  # the unit of another drive
NO_ROUTE = 99
STUCK = 200  # readers


class Trace(ControlCase):
    def trace(self, query=""):
        stream = EventStream(UnixConnection(self.plant.control), path=TRACE + query)
        self.addCleanup(stream.close)
        return stream

    def test_a_transaction_has_both_sides(self):
        stream = self.trace()
        self.assertEqual((stream.status, stream.type), (200, "text/event-stream"))
        self.assertEqual(self.read(MOONS, 0x1E).returncode, 0)
        event = stream.next()
        self.assertEqual(event["event"], "transaction")
        record = event["data"]
        self.assertFalse(record["failed"])
        self.assertEqual(record["client"]["address"], "127.0.0.1")
        request, answer, (wire,) = record["request"], record["answer"], record["wire"]
        self.assertEqual(request["bytes"][-17:], "01 03 00 1E 00 01")
        self.assertEqual(wire["sent"]["bytes"], "01 03 00 1E 00 01 E4 0C")
        self.assertEqual((wire["bus"], wire["device"], wire["outcome"]), ("line-a", "axis-x", "answered"))
        heard = " ".join(part["bytes"] for part in wire["heard"])
        self.assertEqual(heard[3:-6], wire["response"])
        self.assertEqual(answer["bytes"][21:], wire["response"])
        self.assertEqual(answer["bytes"][:5], request["bytes"][:5])
        instants = [request["at"], wire["sent"]["at"], wire["heard"][0]["at"], wire["ended_at"], answer["at"]]
        self.assertEqual(instants, sorted(instants))

    def test_filters_are_kept_to(self):
        streams = [self.trace("?function=4"), self.trace("?device=axis-x"), self.trace("?only=failed")]
        self.assertEqual(self.read(MOONS, 0x1E).returncode, 0)
        self.mbgatectl("read", "input", 0x68, "--unit", AIC, "--port", self.plant.port)
        self.read(NO_ROUTE)
        firsts = [stream.next()["data"] for stream in streams]
        self.assertEqual([record["request"]["bytes"][18:23] for record in firsts], ["11 04", "01 03", "63 03"])
        self.assertTrue(firsts[2]["refused"])
        self.assertEqual(firsts[2]["answer"]["text"][-40:], "exception 0x0A (gateway path unavailable)"[-40:])

    def test_a_wrong_filter_is_refused(self):
        code, body = self.ask("GET", TRACE + "?function=300")
        self.assertEqual((code, body["error"]), (400, "function=300: expected a number, 0 to 255"))

    def test_the_journal_comes_beside_it_for_whoever_asks(self):
        self.edit("[http]\n", "[http]\nmax_streams = 8\n")
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        stream = self.trace("?events=1&device=axis-x")
        kept = stream.find("^configuration in force")
        self.assertEqual({event["event"] for event in kept}, {"journal"})
        self.assertRegex(kept[0]["data"]["text"], "listening")
        alone = EventStream(UnixConnection(self.plant.control), 0)
        self.addCleanup(alone.close)
        self.assertEqual(alone.find("^configuration in force"), kept)
        self.assertEqual(self.read(MOONS, 0x1E).returncode, 0)
        self.assertEqual(stream.next()["event"], "transaction")
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        self.assertEqual(stream.find("nothing has changed")[-1]["event"], "journal")

    def test_before_each_frame_is_silence(self):
        stream = self.trace()
        for _ in range(3):
            self.assertEqual(self.read(MOONS, 0x1E).returncode, 0)
        needed = self.status()["buses"][0]["frame_gap_ms"]
        self.assertEqual(needed, 1.75)
        for _ in range(3):
            (wire,) = stream.next()["data"]["wire"]
            sent, left = (datetime.datetime.fromisoformat(it[:-1]) for it in (wire["sent"]["at"], wire["left_at"]))
            self.assertGreaterEqual(wire["silence_ms"], needed)
            # Eight characters of ten bits at 115200 baud.
            self.assertAlmostEqual((left - sent).total_seconds(), 80 / 115200, delta=2e-6)
            self.assertIsNone(wire["held_until"])

    def test_it_shares_the_places_with_events(self):
        self.edit("[http]\n", "[http]\nmax_streams = 8\n")
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        held = [self.trace(), EventStream(UnixConnection(self.plant.control))]
        self.addCleanup(held[1].close)
        self.assertEqual(self.ask("GET", TRACE)[0], 503)
        self.assertEqual(self.ask("GET", EVENTS)[0], 503)

    def test_readers_that_read_nothing_hold_up_nobody(self):
        self.edit("[http]\n", f"[http]\nmax_streams = {4 * (STUCK + 1)}\n")
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        self.assertEqual([self.trace().status for _ in range(STUCK)], [200] * STUCK)
        reader = self.trace("?client=127.0.0.1")
        for _ in range(5):
            self.assertEqual(self.read(MOONS, 0x1E).returncode, 0)
            self.assertEqual(reader.next()["event"], "transaction")

    def test_it_begins_anew_when_somebody_reads_again(self):
        first = self.trace()
        self.assertEqual(self.read(MOONS).returncode, 0)
        self.assertEqual(first.next()["event"], "transaction")
        first.close()
        self.assertEqual(self.read(MOONS).returncode, 0)
        second = self.trace()
        self.read(AIC)
        limit = time.monotonic() + PATIENCE
        while "unit 17" not in second.next()["data"]["request"]["text"]:
            self.assertLess(time.monotonic(), limit)


if __name__ == "__main__":
    sys.exit(unittest.main())
