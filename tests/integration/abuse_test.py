#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Clients work while others (abusers.py) do all that clients should not do: one without and one with TLS, and one that
connects anew for each question. In rounds of a quiet and a noisy time: no answer is wrong, each question is answered, memory
and journal are bounded, descriptors come back; then a table.

`--rounds 10 --quiet 15 --noisy 45` is ten minutes. `--ratio 1.5`: the 99th of a hundred answers may take so much
longer in the noisy times than in the quiet ones; a busy machine can fail this, so nothing is asked of it otherwise."""

import json
import os
import pathlib
import re
import ssl
import subprocess
import sys
import threading
import time
import unittest

from abusers import HTTP_KINDS, KINDS, TLS_KINDS
from control_case import UnixConnection
import demo_plant
from demo_plant import Process, program
from fault_plant import Client, FaultCase, answer_pdu, is_sanitized, read_of
from machine_faults_test import resident

ARGUMENTS = dict(zip(sys.argv[1::2], map(float, sys.argv[2::2]), strict=False))
PATIENCE = 4 * demo_plant.PATIENCE  # a newcomer waits in a full queue, and the machine may be busy with others
ROUNDS = int(ARGUMENTS.get("--rounds", 2))
QUIET = ARGUMENTS.get("--quiet", 2)  # seconds
NOISY = ARGUMENTS.get("--noisy", 4)
RATIO = ARGUMENTS.get("--ratio")
# What many connections need at most, with what the allocator keeps: 64 of each abuser with its read-ahead, and HTTP.
MEMORY = 48 * 1024 * 1024
LINES_A_MINUTE = 11 * 12  # ten of each kind and listener, and a line that says that there are more
NEWCOMER = "127.0.0.2"
PAUSE = 0.02  # between two connections of the newcomer: max_connects_per_second is 100
PROGRAM = pathlib.Path(__file__).with_name("abusers.py")
TLS = """
[[tls]]
name = "plant"
certificate = "gateway.crt"
key = "gateway.key"
authorities = "ca.crt"
crl = "ca.crl"

[[listen]]
name = "secure"
port = 0
tls = "plant"
"""
COUNTED = ("mbgate_listener_connections_total", "mbgate_listener_displaced_connections_total",
           "mbgate_listener_refused_connections_total", "mbgate_listener_tls_failures_total", "mbgate_listener_requests_total")


class SecureClient(Client):
    def __init__(self, port, identity):
        super().__init__(port)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
        context.load_cert_chain(f"{identity}.crt", f"{identity}.key")
        self._socket = context.wrap_socket(self._socket)


class Newcomer:
    """Connects anew for each question."""

    def __init__(self, port):
        self._port = port

    def ask(self, pdu):
        client = Client(self._port, NEWCOMER, PATIENCE)
        try:
            return client.ask(pdu)
        finally:
            client.close()

    def close(self):
        pass


class Worker:
    """Reads without end and notes how long each answer takes, by `times`: the list of the present time."""

    def __init__(self, client, pause=0):
        self.times = []
        self.all_times = {"quiet": [], "noisy": []}
        self.refused = 0
        self.wrong = []
        self._client = client
        self._pause = pause
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._work)
        self._thread.start()

    def _work(self):
        first = 0
        while not self._ended.is_set() and not self.wrong:
            first = first + 7 & 0x3FFF
            times, begin = self.times, time.monotonic()
            answer = self._client.ask(read_of(first))
            times.append(time.monotonic() - begin)
            if answer[:1] == b"\x83":
                self.refused += 1
            elif answer != answer_pdu(read_of(first)):
                self.wrong.append((first, answer.hex(" ")))
            time.sleep(self._pause)

    def begin(self, when):
        self.times = self.all_times[when]

    def end(self):
        self._ended.set()
        self._thread.join()
        self._client.close()


class Abusers:
    """One of each kind, each at an address of its own."""

    def __init__(self, port, http_port, tls_port, folder):
        self._running = {}
        targets = dict.fromkeys(KINDS, port) | dict.fromkeys(HTTP_KINDS, http_port) | dict.fromkeys(TLS_KINDS, tls_port)
        for number, (kind, target) in enumerate(targets.items()):
            network = "127.0.1" if kind == "refused" else "127.0.0"
            command = [sys.executable, PROGRAM, kind, "--port", str(target), "--address", f"{network}.{10 + number}"]
            command += ["--identity", folder / "abuser"]
            self._running[kind] = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        for abuser in self._running.values():
            assert abuser.stdout.readline() == "connected\n"

    def end(self):
        """What each of them has done."""
        for abuser in self._running.values():
            abuser.terminate()
        done = {kind: json.loads(abuser.communicate(timeout=PATIENCE)[0]) for kind, abuser in self._running.items()}
        assert all(abuser.returncode == 0 for abuser in self._running.values())
        return done


def percentile(times, part):
    return 1000 * sorted(times)[min(len(times) - 1, int(len(times) * part))]


def row(name, *values):
    return f"{name:<24}" + "".join(f"{value:>12}" for value in values)


class Abuse(FaultCase):
    def setUp(self):
        super().setUp()
        self.done = []
        self.memory = []

    def start_plant(self):
        line = self.line()
        text = self.configuration.read_text(encoding="utf-8")
        text = text.replace("[http]\n", '[http]\nlisten = ["127.0.0.1:0"]\n')
        # The limits are those that come with the program.
        text = re.sub(r"(?m)^max_(conn|requests).*\n", "", text)
        text = text.replace("port = 0\n", 'port = 0\nallow = ["127.0.0.0/24"]\n', 1)
        signer = self.folder / "signer"
        text = f'[gateway]\nsigner = "{signer}"\n' + text.replace("[gateway]\n", "") + TLS
        self.configuration.write_text(text, encoding="utf-8")
        self.start_signer(signer)
        self.gateway = Process(self.folder, "mbgated", "--config", self.configuration)
        self.addCleanup(self.gateway.end)
        ports = {}
        while len(ports) < 3:
            found = self.gateway.wait_for(r"listening (\S+) 127\.0\.0\.1:(\d+)$")
            ports[found.group(1)] = int(found.group(2))
        self.port, self.tls_port = ports.pop("plant"), ports.pop("secure")
        return line, *ports.values()

    def start_signer(self, path):
        keys = self.folder / "keys"
        keys.mkdir()
        for words in (["ca"], ["server", "gateway", "--address", "127.0.0.1"], ["client", "abuser"], ["client", "worker"]):
            subprocess.run([program("mbgate-cert"), *words, "--directory", self.folder], check=True,
                           stdout=subprocess.DEVNULL)
        (self.folder / "gateway.key").rename(keys / "gateway.key")
        signer = Process(self.folder, "mbgate-signer", "--keys", keys, "--socket", path)
        self.addCleanup(signer.end)
        signer.wait_for("^listening")

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.gateway.pid}/fd"))

    def wait_for_descriptors(self, most):
        limit = time.monotonic() + PATIENCE
        while self.descriptors() > most:
            self.assertLess(time.monotonic(), limit, f"{self.descriptors()} descriptors are open, before {most}")
            time.sleep(0.05)

    def test_a_client_is_served_beside_all_of_them(self):
        _, http_port = self.start_plant()
        clients = {"plain": Client(self.port), "TLS": SecureClient(self.tls_port, self.folder / "worker")}
        workers = {name: Worker(client) for name, client in clients.items()}
        workers["newcomer"] = Worker(Newcomer(self.port), PAUSE)
        for worker in workers.values():
            self.addCleanup(worker.end)
        time.sleep(1)
        descriptors = self.descriptors() + 1  # of a newcomer
        began = time.monotonic()
        for _ in range(ROUNDS):
            self.work(workers, "quiet", QUIET)
            abusers = Abusers(self.port, http_port, self.tls_port, self.folder)
            self.work(workers, "noisy", NOISY)
            self.memory.append(resident(self.gateway.pid))
            self.done.append(abusers.end())
            self.wait_for_descriptors(descriptors)
        for worker in workers.values():
            self.wait_for_answers(worker)
        lines = self.gateway.unseen()
        self.print_table(workers, lines)
        self.assertEqual([worker.wrong for worker in workers.values()], [[]] * len(workers))
        self.assertLess(len(lines), LINES_A_MINUTE * (2 + (time.monotonic() - began) / 60), "".join(lines))
        if not is_sanitized():  # it keeps what was freed
            self.assertLess(max(self.memory), self.memory[0] + MEMORY)
        if RATIO:
            times = workers["plain"].all_times
            quiet, noisy = (percentile(times[when], 0.99) for when in ("quiet", "noisy"))
            self.assertLessEqual(noisy, RATIO * quiet)
            self.assertEqual(workers["plain"].refused, 0)

    def work(self, workers, when, seconds):
        for worker in workers.values():
            worker.begin(when)
        time.sleep(seconds)

    def wait_for_answers(self, worker):
        asked = len(worker.times)
        limit = time.monotonic() + PATIENCE
        while len(worker.times) < asked + 10 and not worker.wrong:
            self.assertLess(time.monotonic(), limit, "no answers any more")
            time.sleep(0.01)

    def print_table(self, workers, lines):
        print(row("answers, in ms", "count", "p50", "p99", "longest"))
        for name, worker in workers.items():
            for when, times in worker.all_times.items():
                figures = (f"{percentile(times, part):.2f}" for part in (0.5, 0.99, 1))
                print(row(f"{name}, {when}", len(times), *figures))
            quiet, noisy = (percentile(worker.all_times[when], 0.99) for when in ("quiet", "noisy"))
            print(row("p99, noisy to quiet", f"{noisy / quiet:.2f}"))
            print(row("wrong, refused", len(worker.wrong), worker.refused))
        print(row("memory, MiB", *(f"{size / 2**20:.1f}" for size in (self.memory[0], self.memory[-1]))))
        print(row("lines of the journal", len(lines)))
        for line in self.metrics():
            print(line)
        for kind in self.done[0]:
            total = {}
            for round_of in self.done:
                for what, count in round_of[kind].items():
                    total[what] = total.get(what, 0) + count
            print(f"{kind:<24}" + ", ".join(f"{what} {count}" for what, count in total.items()))

    def metrics(self):
        connection = UnixConnection(self.control)
        connection.request("GET", "/metrics")
        text = connection.getresponse().read().decode()
        connection.close()
        return [line for line in text.splitlines() if line.startswith(COUNTED) and not line.endswith(" 0")]


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
