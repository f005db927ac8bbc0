#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Shows that arrows.py finds what it is there to find: each test makes a small tree with one thing wrong."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE))
sys.dont_write_bytecode = True

import arrows  # noqa: E402  (the path must be set first)

LICENCE = "// SPDX-License-Identifier: Apache-2.0\n"


def findings(path, *lines):
    """What arrows.py says of a tree that has only the file `path` with these lines below the licence."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, path)
        file.parent.mkdir(parents=True)
        file.write_text(LICENCE + "".join(f"{line}\n" for line in lines), encoding="utf-8")
        found, files = arrows.check_tree(pathlib.Path(folder))
        assert files == 1, path
        return found


class Arrows(unittest.TestCase):
    def test_an_arrow_may_be_followed(self):
        self.assertEqual(findings("src/bus/a.cpp", '#include "drive/device.hpp"', '#include "modbus/pdu.hpp"'), [])
        self.assertEqual(findings("src/app/a.cpp", '#include "io/tty.hpp"', "#include <boost/asio/post.hpp>"), [])
        self.assertEqual(findings("tests/unit/bus/a.cpp", '#include "bus/bus.hpp"', "#include <gtest/gtest.h>"), [])
        self.assertEqual(findings("tests/simulation/a.cpp", '#include "sim/wire.hpp"'), [])

    def test_routing_and_bus_do_not_know_each_other(self):
        self.assertEqual(
            findings("src/bus/a.cpp", '#include "routing/plan.hpp"'),
            ['src/bus/a.cpp: includes "routing/plan.hpp", but no arrow leads from here to routing/'],
        )
        self.assertEqual(len(findings("src/routing/a.hpp", "#pragma once", '#include "bus/bus.hpp"')), 1)

    def test_nobody_looks_up(self):
        for path, header in (
            ("src/modbus/a.cpp", "drive/device.hpp"),
            ("src/gateway/a.cpp", "io/tty.hpp"),
            ("src/gateway/a.cpp", "config/diagnostic.hpp"),
            ("src/io/a.cpp", "app/log.hpp"),
            ("src/io/a.cpp", "config/diagnostic.hpp"),
            ("src/config/a.cpp", "gateway/gateway.hpp"),
            ("src/sim/a.cpp", "gateway/gateway.hpp"),
            ("src/ctl/a.cpp", "io/tty.hpp"),
            ("tests/unit/bus/a.cpp", "gateway/gateway.hpp"),
            ("tests/simulation/a.cpp", "io/tty.hpp"),
            ("tests/integration/a.cpp", "modbus/pdu.hpp"),
        ):
            with self.subTest(path=path, header=header):
                self.assertEqual(len(findings(path, f'#include "{header}"')), 1)

    def test_a_room_of_its_own_must_be_known(self):
        self.assertEqual(
            findings("src/attic/a.cpp", '#include "modbus/pdu.hpp"'),
            ["src/attic/a.cpp: stands in no room that tests/tidy/arrows.py knows"],
        )

    def test_libraries_stay_in_their_rooms(self):
        for path, header in (
            ("src/config/a.cpp", "boost/asio.hpp"),
            ("src/sim/drive.cpp", "boost/asio/post.hpp"),
            ("src/config/gateway_section.cpp", "toml++/toml.h"),
            ("src/io/a.cpp", "systemd/sd-daemon.h"),
            ("src/app/service.cpp", "systemd/sd-daemon.h"),
            ("src/io/a.cpp", "modbus/modbus.h"),
            ("src/config/a.cpp", "CLI/CLI.hpp"),
            ("src/io/a.cpp", "gtest/gtest.h"),
        ):
            with self.subTest(path=path, header=header):
                self.assertEqual(len(findings(path, f"#include <{header}>")), 1)

    def test_pure_rooms_have_no_outside(self):
        for line in (
            "#include <thread>",
            "#include <mutex>",
            "#include <iostream>",
            "#include <sys/socket.h>",
            "#include <arpa/inet.h>",
            "const auto now = std::chrono::steady_clock::now();",
            "const auto now = std::chrono::system_clock::now();",
        ):
            with self.subTest(line=line):
                self.assertEqual(len(findings("src/bus/a.cpp", line)), 1)
        self.assertEqual(len(findings("src/bus/a.cpp", "#include <boost/asio/post.hpp>")), 2)
        self.assertEqual(findings("src/routing/client_address.cpp", "#include <arpa/inet.h>"), [])
        self.assertEqual(findings("src/bus/a.cpp", "// Never steady_clock::now() here."), [])
        self.assertEqual(findings("src/bus/a.cpp", "#include <chrono>", "#include <boost/system/result.hpp>"), [])

    def test_a_source_has_its_licence_its_length_and_its_guard(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "src/bus/a.hpp")
            file.parent.mkdir(parents=True)
            file.write_text("#include <span>\n" * 301, encoding="utf-8")
            found, _ = arrows.check_tree(pathlib.Path(folder))
        self.assertEqual(
            found,
            [
                "src/bus/a.hpp: the first line must be // SPDX-License-Identifier: Apache-2.0",
                "src/bus/a.hpp: has 301 lines, more than 300",
                "src/bus/a.hpp: a header without #pragma once",
            ],
        )

    def test_scripts_have_their_licence(self):
        self.assertEqual(
            arrows.check_script("tests/a.py", "#!/usr/bin/python3\nimport os\n"),
            ["tests/a.py: the first line (after #!) must be # SPDX-License-Identifier: Apache-2.0"],
        )

    def test_the_command_fails_on_a_finding_and_on_an_empty_tree(self):
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, str(HERE / "arrows.py"), folder]
            self.assertEqual(subprocess.run(command, capture_output=True, check=False).returncode, 1)
            file = pathlib.Path(folder, "src/bus/a.cpp")
            file.parent.mkdir(parents=True)
            file.write_text(LICENCE, encoding="utf-8")
            self.assertEqual(subprocess.run(command, capture_output=True, check=False).returncode, 0)
            file.write_text(LICENCE + '#include "routing/plan.hpp"\n', encoding="utf-8")
            self.assertEqual(subprocess.run(command, capture_output=True, check=False).returncode, 1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
