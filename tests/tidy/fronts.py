# SPDX-License-Identifier: Apache-2.0
"""Which headers of a folder within a module others may include (a part of arrows.py; see src/README.md)."""

HERE = "tests/tidy/fronts.py"

# The folders within the modules, and their front headers: those that others may include. The other headers of a folder, and of
# the folders in it, are its own; its tests see them, and those that stand beside the folders of tests/unit/MODULE.
FRONTS = {
    "app/configuration": {"digest"},
    "app/control": {"control"},
    "app/journal": {"event_topic", "journal"},
    "app/metrics": {"metrics"},
    "app/page": {"page_answer"},
    "app/tls": {"certificates"},
    "app/trace": {"trace_json"},
    "app/who": {"who_options"},
    "bus/health": {"device_table", "line_diagnosis", "line_quality", "probes"},
    "bus/queue": {"bus_queue", "fairness", "scheduler", "stop_lane"},
    "bus/serial": {"serial_discipline"},
    "bus/tcp": {"tcp_discipline"},
    "bus/transmission": {"dispatch", "job_ends", "outcomes", "read_cache", "transmission"},
    "config/checks": set(),  # config/sections declares them, beside the sections that they look at
    "config/keys": {"keys"},
    "config/profiles": {"profile_entries", "profile_file", "profile_library"},
    "config/sections": {"sections"},
    "config/toml": {"match_entry", "suggestion", "toml_reader", "toml_value"},
    "ctl/control": {"connection_shell", "event_reader"},
    "ctl/doctor": set(),
    "ctl/options": {"subcommands"},
    "ctl/profile": {"profile_text"},
    "ctl/replay": set(),
    "ctl/request": {"carry_out", "command", "modbus_client", "repetition", "value_text"},
    "ctl/scan": {"scan"},
    "ctl/serial": {"heard", "serial_client", "serial_port"},
    "ctl/tls": {"handshake"},
    "ctl/trace": set(),
    "gateway/access": {"report_limit", "rule_verdict", "who"},
    "gateway/clients": {"clients", "sessions"},
    "gateway/exchanges": {"exchanges"},
    "gateway/status": {"status_report"},
    "gateway/trace": {"trace_book", "trace_record"},
    "gateway/settings": {"settings_snapshot"},
    "gateway/writes": {"failsafe_writes", "write_rules"},
    "io/clients": {"client_connections", "hangup_watch", "listening_socket", "resources", "tcp_server"},
    "io/lines": {"line"},
    "io/tls": {
        "fingerprint", "load_tls", "pem_files", "signer_client", "tls_door",
    },
    "io/uplink": {"tls_uplink"},
    "report/findings": {"diagnosis", "findings"},
    "report/recording": {"record"},
    "sim/drives": {"device"},
    "sim/program": {"simulator"},
    "sim/wire": {"request_framer", "tcp_bus", "wire"},
}
# Tests of several modules, and the bench, see these behind the front headers too.
BEHIND = {
    "fuzz": {
        "app/control/event_streams.hpp", "app/control/tcp_rules.hpp", "bus/serial/framer.hpp", "ctl/replay/replay.hpp",
    },
    "drives": {
        "sim/drives/aic_drive.hpp", "sim/drives/moons_drive.hpp", "sim/drives/stepper_drive.hpp",
        "sim/drives/maps/aic_map.hpp", "sim/drives/maps/fda6000_map.hpp", "sim/drives/maps/moons_map.hpp",
        "sim/drives/maps/stepper_map.hpp",
    },
    "bench": {"sim/program/pty.hpp"},
}


def fronts_of(folder):
    return {f"{folder}/{name}.hpp" for name in FRONTS.get(folder, ())}


def reach_of(path):
    """The headers behind the front ones that the file `path` may include."""
    parts = path.split("/")
    return BEHIND.get("bench" if parts[0] == "bench" else parts[1] if parts[0] == "tests" else "", set())


def is_within(path, folder):
    """Is the file `path` one of the folder "module/name", or of its tests?"""
    unit = f"tests/unit/{folder.split('/')[0]}/"
    beside = path.startswith(unit) and "/" not in path[len(unit):]
    return beside or path.startswith((f"src/{folder}/", f"tests/unit/{folder}/"))


def check_includes(includes):
    """Of all pairs of a file and a header that it includes: does it reach behind the front headers of another folder?"""
    found = []
    for path, header in includes:
        folder = "/".join(header.split("/")[:2])
        if folder in FRONTS and not is_within(path, folder) and header not in fronts_of(folder) | reach_of(path):
            found.append(f'{path}: includes "{header}", which is no front header of {folder}/')
    return found


def check_tables(root, includes):
    """What FRONTS and BEHIND say, against the tree: every folder is known, and what they name is there and is used."""
    sources = [file.relative_to(root / "src") for file in (root / "src").rglob("*.?pp")]
    folders = {"/".join(file.parts[:2]) for file in sources if len(file.parts) > 2}
    found = [f"src/{folder}: {HERE} does not know its front headers" for folder in sorted(folders - set(FRONTS))]
    found += [f"{HERE}: knows src/{folder}, which is not there" for folder in sorted(set(FRONTS) - folders)]
    users = {}
    for path, header in includes:
        users.setdefault(header, set()).add(path)
    for folder in sorted(FRONTS):
        for header in sorted(fronts_of(folder)):
            if not (root / "src" / header).is_file():
                found.append(f"{HERE}: names {header}, which is not there")
            elif all(is_within(path, folder) or not path.startswith("src/") for path in users.get(header, ())):
                found.append(f"{HERE}: names {header} as a front header, but nothing else in src/ includes it")
    for tests, headers in sorted(BEHIND.items()):
        start = "bench/" if tests == "bench" else f"tests/{tests}/"
        for header in sorted(headers):
            if header in fronts_of("/".join(header.split("/")[:2])):
                found.append(f"{HERE}: {header} is a front header, and need not be named for {start}")
            elif not any(path.startswith(start) for path in users.get(header, ())):
                found.append(f"{HERE}: names {header} for {start}, which does not include it")
    return found


def check_mirror(root, path):
    """A unit test stands in the folder of what it tests."""
    folder = "/".join(path.split("/")[2:-1])
    if not path.startswith("tests/unit/") or "/" not in folder or (root / "src" / folder).is_dir():
        return []
    return [f"{path}: there is no folder src/{folder}"]


def check(root, includes):
    """All findings about the folders of `root`; `includes` are pairs of a file and a header that it includes."""
    return check_includes(includes) + check_tables(root, includes)
