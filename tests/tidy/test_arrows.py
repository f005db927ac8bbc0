#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Shows that arrows.py finds what it is there to find: each test makes a small tree with one thing wrong."""

import contextlib
import io
import pathlib
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE))
sys.dont_write_bytecode = True

import arrows  # noqa: E402  (the path must be set first)
import fronts  # noqa: E402

LICENCE = "// SPDX-License-Identifier: Apache-2.0\n"


def findings(path, *lines):
    """What arrows.py says of a tree that has only the file `path` with these lines below the licence."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, path)
        file.parent.mkdir(parents=True)
        file.write_text(LICENCE + "".join(f"{line}\n" for line in lines), encoding="utf-8")
        with tables({}):
            found, files = arrows.check_tree(pathlib.Path(folder))
        assert files == 1, path
        return found


@contextlib.contextmanager
def tables(front, behind=None):
    """Other tables than those of this repository, for a tree that has not its folders."""
    with mock.patch.object(fronts, "FRONTS", front), mock.patch.object(fronts, "BEHIND", behind or {}):
        yield


# A tree in which all is well: bus/serial has a front header, which bus/ includes, and two of its own.
FRONTS = {"bus/serial": {"line"}}
BEHIND = {"fuzz": {"bus/serial/framer.hpp"}}
SERIAL = {
    "src/bus/bus.hpp": "bus/serial/line.hpp",
    "src/bus/serial/line.hpp": "bus/serial/framer.hpp",
    "src/bus/serial/framer.hpp": "bus/serial/parts/noise.hpp",
    "src/bus/serial/parts/noise.hpp": "modbus/pdu.hpp",
    "tests/fuzz/framer.cpp": "bus/serial/framer.hpp",
    "tests/unit/bus/serial/framer_test.cpp": "bus/serial/framer.hpp",
    "tests/unit/bus/rig.hpp": "bus/serial/framer.hpp",
}


def findings_in_serial(changes=None, front=None, behind=None):
    """What arrows.py says of that tree with other includes (none: without the file), or with other tables."""
    with tempfile.TemporaryDirectory() as folder:
        for path, header in (SERIAL | (changes or {})).items():
            if header is not None:
                file = pathlib.Path(folder, path)
                file.parent.mkdir(parents=True, exist_ok=True)
                guard = "\n#pragma once\n" if path.endswith(".hpp") else ""
                file.write_text(f'{LICENCE}{guard}#include "{header}"\n', encoding="utf-8")
        with tables(FRONTS if front is None else front, BEHIND if behind is None else behind):
            return arrows.check_tree(pathlib.Path(folder))[0]


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
            ("src/ctl/a.cpp", "gateway/gateway.hpp"),
            ("tests/unit/bus/a.cpp", "gateway/gateway.hpp"),
            ("tests/simulation/a.cpp", "io/tty.hpp"),
            ("tests/integration/a.cpp", "modbus/pdu.hpp"),
        ):
            with self.subTest(path=path, header=header):
                self.assertEqual(len(findings(path, f'#include "{header}"')), 1)

    def test_a_replay_sees_the_machine_and_the_rest_of_its_module_does_not(self):
        for folder in ("src/ctl", "tests/unit/ctl"):
            for path, header, number in (("replay/a.cpp", "gateway/gateway.hpp", 0), ("replay/a.cpp", "config/load.hpp", 0),
                                         ("replay/a.cpp", "io/tty.hpp", 1), ("scan/a.cpp", "gateway/gateway.hpp", 1)):
                with self.subTest(folder=folder, path=path, header=header):
                    self.assertEqual(len(arrows.check_module(f"{folder}/{path}", header)), number)

    def test_a_module_of_its_own_must_be_known(self):
        self.assertEqual(
            findings("src/attic/a.cpp", '#include "modbus/pdu.hpp"'),
            ["src/attic/a.cpp: stands in no module that tests/tidy/arrows.py knows"],
        )

    def test_libraries_stay_in_their_modules(self):
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

    def test_pure_modules_have_no_outside(self):
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
            with tables({}):
                found, _ = arrows.check_tree(pathlib.Path(folder))
        self.assertEqual(
            found,
            [
                "src/bus/a.hpp: the first line must be // SPDX-License-Identifier: Apache-2.0",
                "src/bus/a.hpp: has 301 lines, more than 300",
                "src/bus/a.hpp: a header without #pragma once",
            ],
        )

    def test_a_folder_has_no_more_modules_than_a_reader_keeps_in_mind(self):
        with tempfile.TemporaryDirectory() as folder:
            module = pathlib.Path(folder, "src/bus")
            (module / "serial").mkdir(parents=True)
            for number in range(20):
                for suffix in (".hpp", ".cpp"):
                    (module / f"a{number}{suffix}").touch()
            (module / "serial/b.hpp").touch()
            self.assertEqual(arrows.check_crowding(pathlib.Path(folder)), [])
            (module / "b.hpp").touch()
            self.assertEqual(
                arrows.check_crowding(pathlib.Path(folder)), ["src/bus: has 21 units, more than 20"]
            )

    def test_the_proofs_keep_their_sizes(self):
        with tempfile.TemporaryDirectory() as folder:
            tests = pathlib.Path(folder, "tests")
            for name in ("world", "explore", "mutations"):
                (tests / name).mkdir(parents=True)
            (tests / "world/a.cpp").write_text("\n" * 10_500, encoding="utf-8")
            (tests / "explore/a.hpp").write_text("\n" * 2_900, encoding="utf-8")
            self.assertEqual(arrows.check_budgets(pathlib.Path(folder)), [])
            (tests / "world/b.cpp").write_text("\n", encoding="utf-8")
            for page in (tests / "README.md", tests.parent / "README.md"):
                page.write_text("\n" * 201, encoding="utf-8")
            (tests.parent / "src").mkdir()
            (tests.parent / "src/a.cpp").write_text("\n" * (arrows.MOST_SOURCE_LINES + 1), encoding="utf-8")
            for number in range(31):
                (tests / f"mutations/{number}.patch").touch()
            self.assertEqual(
                arrows.check_budgets(pathlib.Path(folder)),
                [f"src: has {arrows.MOST_SOURCE_LINES + 1} lines, more than {arrows.MOST_SOURCE_LINES}",
                 "tests/{world,judge}: have 10501 lines, more than 10500",
                 "tests/{world,judge,simulation,explore}: have 13401 lines, more than 13400",
                 "tests/mutations: has 31 patches, more than 30",
                 "README.md: has 201 lines, more than 200",
                 "tests/README.md: has 201 lines, more than 200"],
            )

    def test_a_folder_has_front_headers_and_others_of_its_own(self):
        self.assertEqual(findings_in_serial(), [])
        for path in ("src/bus/bus.cpp", "src/bus/tcp.cpp", "src/gateway/a.cpp", "tests/unit/gateway/a.cpp",
                     "tests/world/a.cpp", "bench/a.cpp"):
            with self.subTest(path=path):
                self.assertEqual(findings_in_serial({path: "bus/serial/line.hpp"}), [])
                self.assertEqual(
                    findings_in_serial({path: "bus/serial/framer.hpp"}),
                    [f'{path}: includes "bus/serial/framer.hpp", which is no front header of bus/serial/'],
                )
        # Nor do folders within the folder open another way, nor the tests of another folder.
        for path, header in (("src/bus/a.cpp", "bus/serial/parts/noise.hpp"),
                             ("tests/fuzz/a.cpp", "bus/serial/parts/noise.hpp")):
            with self.subTest(path=path):
                self.assertEqual(len(findings_in_serial({path: header})), 1)
        both = FRONTS | {"bus/tcp": set()}
        tests_of_another = {"src/bus/tcp/a.cpp": "bus/instant.hpp", "tests/unit/bus/tcp/a.cpp": "bus/serial/framer.hpp"}
        self.assertEqual(
            findings_in_serial(tests_of_another, front=both),
            ['tests/unit/bus/tcp/a.cpp: includes "bus/serial/framer.hpp", which is no front header of bus/serial/'],
        )

    def test_the_table_of_front_headers_knows_every_folder_and_no_other(self):
        self.assertEqual(
            findings_in_serial({"src/bus/attic/a.cpp": "bus/instant.hpp"}),
            ["src/bus/attic: tests/tidy/fronts.py does not know its front headers"],
        )
        self.assertEqual(
            findings_in_serial(front=FRONTS | {"bus/attic": set()}),
            ["tests/tidy/fronts.py: knows src/bus/attic, which is not there"],
        )

    def test_the_table_of_front_headers_names_what_is_there_and_is_used(self):
        self.assertEqual(
            findings_in_serial(front={"bus/serial": {"line", "gone"}}),
            ["tests/tidy/fronts.py: names bus/serial/gone.hpp, which is not there"],
        )
        self.assertEqual(
            findings_in_serial({"src/bus/bus.hpp": "bus/instant.hpp"}),
            ["tests/tidy/fronts.py: names bus/serial/line.hpp as a front header, but nothing else in src/ includes it"],
        )

    def test_what_tests_see_behind_the_front_headers_is_used_too(self):
        named = "tests/tidy/fronts.py: names bus/serial/framer.hpp for tests/fuzz/, which does not include it"
        self.assertEqual(findings_in_serial({"tests/fuzz/framer.cpp": None}), [named])
        self.assertEqual(
            findings_in_serial(behind=BEHIND | {"bench": {"bus/serial/line.hpp"}}),
            ["tests/tidy/fronts.py: bus/serial/line.hpp is a front header, and need not be named for bench/"],
        )

    def test_unit_tests_have_the_folders_of_the_sources(self):
        self.assertEqual(
            findings_in_serial({"tests/unit/bus/attic/a_test.cpp": "bus/bus.hpp"}),
            ["tests/unit/bus/attic/a_test.cpp: there is no folder src/bus/attic"],
        )

    def test_the_bench_shares_one_header_with_the_tests_and_the_sources_none(self):
        self.assertEqual(findings("bench/a.cpp", '#include "support/gateway_harness.hpp"'), [])
        for path, header in (("bench/a.cpp", "support/machine_rig.hpp"), ("src/bus/a.cpp", "support/gateway_harness.hpp")):
            with self.subTest(path=path):
                self.assertEqual(
                    findings(path, f'#include "{header}"'),
                    [f'{path}: includes "{header}", but no arrow leads from here to the tests'],
                )

    def test_scripts_have_their_licence(self):
        self.assertEqual(
            arrows.check_script("tests/a.py", "#!/usr/bin/python3\nimport os\n"),
            ["tests/a.py: the first line (after #!) must be # SPDX-License-Identifier: Apache-2.0"],
        )

    def test_the_command_fails_on_a_finding_and_on_an_empty_tree(self):
        with tempfile.TemporaryDirectory() as folder:
            command = [str(HERE / "arrows.py"), folder]
            run = subprocess.run([sys.executable, *command], capture_output=True, check=False)
            self.assertEqual(run.returncode, 1)
            file = pathlib.Path(folder, "src/bus/a.cpp")
            file.parent.mkdir(parents=True)
            for line, status in (("", 0), ('#include "routing/plan.hpp"\n', 1)):
                file.write_text(LICENCE + line, encoding="utf-8")
                with tables({}), mock.patch.object(sys, "argv", command), contextlib.redirect_stdout(io.StringIO()):
                    self.assertEqual(arrows.main(), status)


if __name__ == "__main__":
    unittest.main(verbosity=2)
