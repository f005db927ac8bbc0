#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The units as systemd-analyze sees them: nothing to complain of, and how exposed mbgated is, as shipped and with each
of the drop-ins for users."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest

ROOT = pathlib.Path(__file__).parents[2]
SKIPPED = 77
UNITS = (
    "mbgated.service", "mbgated.socket", "mbgated-http.socket", "mbgate-signer.service", "mbgate-signer.socket",
)


def lay_out(folder, *drop_ins):
    """The units in a folder, with programs that exist where nothing is installed; returns the service's path."""
    folder = pathlib.Path(folder)
    for name in UNITS:
        text = (ROOT / "systemd" / name).read_text(encoding="utf-8")
        text = re.sub(r"^(Exec\w+=)/usr/s?bin/mbgate[\w-]+", r"\1/bin/true", text, flags=re.MULTILINE)
        (folder / name).write_text(text, encoding="utf-8")
    added = folder / "mbgated.service.d"
    added.mkdir()
    for name in drop_ins:
        shutil.copy(ROOT / "systemd" / name, added)
    return folder / "mbgated.service"


def analyze(*arguments):
    return subprocess.run(["systemd-analyze", *arguments], check=False, text=True, capture_output=True, timeout=60,
                          env=os.environ | {"LC_ALL": "C.UTF-8"})


def section(name, title):
    """The keys of a unit's section; each with all of its values, since some are given again and again."""
    values = {}
    current = None
    for line in (ROOT / "systemd" / name).read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            current = line.strip("[]")
        elif current == title and "=" in line and not line.startswith("#"):
            key, _, value = line.partition("=")
            values.setdefault(key, []).append(value)
    return values


class Verify(unittest.TestCase):
    def check(self, *drop_ins):
        with tempfile.TemporaryDirectory() as folder:
            lay_out(folder, *drop_ins)
            # It exits 0 where it does not know a key: only its words say so.
            seen = analyze("verify", "--man=no", *(str(pathlib.Path(folder) / name) for name in UNITS))
            self.assertEqual((0, ""), (seen.returncode, seen.stderr))

    def test_has_nothing_to_say_of_the_units(self):
        self.check()

    def test_has_nothing_to_say_of_the_drop_ins(self):
        for name in ("socket-only.conf", "port-502.conf", "realtime.conf"):
            self.check(name)

    def test_names_a_key_that_is_not_known(self):
        with tempfile.TemporaryDirectory() as folder:
            service = lay_out(folder)
            service.write_text(service.read_text(encoding="utf-8") + "[Service]\nPrivateUser=yes\n", encoding="utf-8")
            self.assertIn("'PrivateUser'", analyze("verify", "--man=no", str(service)).stderr)


class Exposure(unittest.TestCase):
    """In tenths, as systemd-analyze takes a threshold; it is that of the unit in its file, without starting it."""

    def check(self, most, *drop_ins):
        with tempfile.TemporaryDirectory() as folder:
            service = lay_out(folder, *drop_ins)
            seen = analyze("security", "--offline=yes", "--no-pager", f"--threshold={most}", str(service))
            self.assertRegex(seen.stdout, "Overall exposure level for mbgated.service: ")
            last = seen.stdout.strip().splitlines()[-1]
            self.assertEqual((0, ""), (seen.returncode, seen.stderr), last)

    def test_as_shipped(self):
        self.check(12)

    def test_with_sockets_of_systemd_only(self):
        self.check(5, "socket-only.conf")

    def test_where_it_binds_port_502_itself(self):
        self.check(16, "port-502.conf")

    def test_with_realtime(self):
        self.check(12, "realtime.conf")

    def test_of_the_process_that_holds_the_keys(self):
        with tempfile.TemporaryDirectory() as folder:
            signer = lay_out(folder).with_name("mbgate-signer.service")
            seen = analyze("security", "--offline=yes", "--no-pager", "--threshold=2", str(signer))
            self.assertRegex(seen.stdout, "Overall exposure level for mbgate-signer.service: ")
            self.assertEqual((0, ""), (seen.returncode, seen.stderr), seen.stdout.strip().splitlines()[-1])

    def test_can_fail(self):
        with self.assertRaises(AssertionError):
            self.check(5)


class Sockets(unittest.TestCase):
    def test_have_the_names_that_the_shipped_configuration_has(self):
        configuration = tomllib.loads((ROOT / "conf/mbgate.toml").read_text(encoding="utf-8"))
        plant = {listener["name"]: listener["port"] for listener in configuration["listen"]}
        name = section("mbgated.socket", "Socket")["FileDescriptorName"][0]
        self.assertEqual([str(plant[name])], section("mbgated.socket", "Socket")["ListenStream"])
        self.assertEqual(["http"], section("mbgated-http.socket", "Socket")["FileDescriptorName"])

    def test_go_with_the_service_that_is_stopped(self):
        for name in ("mbgated.socket", "mbgated-http.socket"):
            self.assertEqual(["mbgated.service"], section(name, "Unit")["StopPropagatedFrom"])
            self.assertEqual(["sockets.target mbgated.service"], section(name, "Install")["WantedBy"])

    def test_queue_and_watch_connections_as_the_listener_does(self):
        configuration = tomllib.loads((ROOT / "conf/mbgate.toml").read_text(encoding="utf-8"))
        listener, socket = configuration["listen"][0], section("mbgated.socket", "Socket")
        self.assertEqual(listener["name"], socket["FileDescriptorName"][0])
        self.assertEqual(str(listener["backlog"]), socket["Backlog"][0])
        self.assertEqual(listener["keepalive_idle"], socket["KeepAliveTimeSec"][0])
        self.assertEqual(listener["keepalive_interval"], socket["KeepAliveIntervalSec"][0])
        self.assertEqual(str(listener["keepalive_probes"]), socket["KeepAliveProbes"][0])


class Sandbox(unittest.TestCase):
    SERVICES = {"mbgated.service": ["mbgated", "mbgatectl"], "mbgate-signer.service": ["mbgate-signer"]}
    # Mounts as systemd makes them, with the programs of this build in the place of the installed ones.
    ALONE = """
        mount --make-rprivate /
        for path in $EXEC_PATHS; do mount --bind "$path" "$path"; done
        mount -o remount,bind,noexec /
        exec "$@"
    """

    def test_nothing_but_their_programs_can_be_run(self):
        for service, programs in self.SERVICES.items():
            settings = section(service, "Service")
            self.assertEqual(["/"], settings["NoExecPaths"])
            allowed = settings["ExecPaths"][0].split()
            run = [words[0].split()[0] for key, words in settings.items() if re.fullmatch("Exec[SR][a-z]+", key)]
            self.assertEqual(programs, [pathlib.Path(path).name for path in run])
            self.assertLessEqual(set(run), set(allowed))
            others = set(allowed) - set(run) - {"/usr/lib", "-/usr/lib64", "/usr/bin/kill"}
            self.assertEqual(set(), others)

    def test_their_programs_can_be_run(self):
        if subprocess.run(["unshare", "-m", "true"], check=False, stderr=subprocess.DEVNULL).returncode != 0:
            self.skipTest("only root makes mounts")
        folder = os.environ.get("MBGATE_PROGRAMS", os.environ.get("PATH", "") + ":/usr/sbin")
        for service, programs in self.SERVICES.items():
            if not (built := {name: shutil.which(name, path=folder) for name in programs}) or None in built.values():
                self.skipTest("the programs are not there")
            allowed = [built.get(path.rpartition("/")[2], path) for path in
                       section(service, "Service")["ExecPaths"][0].split() if not path.startswith("-")]

            def alone(*command, allowed=tuple(allowed)):
                return subprocess.run(["unshare", "-m", "sh", "-ec", self.ALONE, "sh", *command], check=False, text=True,
                                      capture_output=True, env=os.environ | {"EXEC_PATHS": " ".join(allowed)})

            for name, path in built.items():
                done = alone(path, "--version")
                self.assertEqual((0, f"{name} "), (done.returncode, done.stdout[:len(name) + 1]), done.stderr)
            self.assertIn("Permission denied", alone("/bin/sh", "-c", "echo out of it").stderr)

    def test_listen_for_tcp_alone_and_ask_no_other_service(self):
        for service in self.SERVICES:
            settings = section(service, "Service")
            self.assertEqual(["any"], settings["SocketBindDeny"])
            self.assertEqual(["tcp"] if service == "mbgated.service" else None, settings.get("SocketBindAllow"))
            self.assertEqual(["-/run/dbus"], settings["InaccessiblePaths"])

    def test_mbgated_waits_for_the_time(self):
        self.assertIn("time-set.target", " ".join(section("mbgated.service", "Unit")["After"]))


class Signer(unittest.TestCase):
    def test_has_the_socket_that_its_page_and_the_configuration_say(self):
        path = section("mbgate-signer.socket", "Socket")["ListenSequentialPacket"][0]
        user, mode = (section("mbgate-signer.socket", "Socket")[key][0] for key in ("SocketUser", "SocketMode"))
        page = (ROOT / "debian/man/mbgate-signer.8").read_text(encoding="utf-8").replace("\\-", "-")
        said = re.search(rf"\.I {path}\n(?:[^.].*\n|\.B.*\n)+", page)
        self.assertIsNotNone(said, "the page has another socket than the unit")
        self.assertIn(f"for the user {user} alone, {user}:{user} {mode}.", said.group())
        configuration = tomllib.loads((ROOT / "conf/mbgate.toml").read_text(encoding="utf-8"))
        self.assertEqual(path, configuration["gateway"]["signer"])
        self.assertEqual(user, section("mbgated.service", "Service")["User"][0])

    def test_has_the_folders_that_its_page_says(self):
        page = (ROOT / "debian/man/mbgate-signer.8").read_text(encoding="utf-8").replace("\\-", "-")
        for word in section("mbgate-signer.service", "Service")["ExecStart"][0].split()[1:]:
            self.assertIn(word, page)


if __name__ == "__main__":
    if shutil.which("systemd-analyze") is None:
        print("skipped: systemd-analyze is not installed")
        sys.exit(SKIPPED)
    unittest.main()
