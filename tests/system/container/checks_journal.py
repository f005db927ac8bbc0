# SPDX-License-Identifier: Apache-2.0
"""Entries with fields, and the catalog that explains them."""

import json
import re

import modbus
from plant import PORT


def fields(plant):
    report = plant.report
    plant.fresh()
    plant.start()
    with modbus.Client(PORT) as client:
        for unit in (1, 99, 99, 99, 99, 77):
            try:
                client.read(unit, 30)
            except modbus.Refused:
                pass
    plant.says("line-b")
    entries = [json.loads(line) for line in plant.journal("-o", "json").splitlines()]
    own = [entry for entry in entries if entry.get("_COMM") == "mbgated" or entry.get("SYSLOG_IDENTIFIER") == "mbgated"]
    for field in ("MESSAGE_ID", "MBGATE_BUS", "MBGATE_DEVICE", "MBGATE_CLIENT"):
        found = next((entry for entry in own if field in entry), None)
        report.check(f"journalctl -o json: an entry with {field}", bool(found),
                     f"{found[field]}: {found['MESSAGE']}" if found else f"none in {len(own)} entries")
    without = [entry["MESSAGE"] for entry in own if "MESSAGE_ID" not in entry]
    report.told("entries of mbgated without MESSAGE_ID", f"{len(without)} of {len(own)}: {'; '.join(without[:3])}")
    shown = plant.container.run("journalctl", "-q", "MBGATE_BUS=line-b", "-o", "cat").output
    report.check("journalctl MBGATE_BUS=line-b finds what is said of it", "line-b" in shown, shown.splitlines()[:1])
    unexplained = []
    explained = 0
    unfilled = set()
    for identifier in sorted({entry["MESSAGE_ID"] for entry in own if "MESSAGE_ID" in entry}):
        text = plant.container.run("journalctl", "-q", "-x", "-n", "1", f"MESSAGE_ID={identifier}").output
        explanation = [line for line in text.splitlines() if line.startswith("░░")]
        explained += len(explanation) > 3
        unfilled.update(re.findall("@MBGATE_[A-Z]+@", text))
        if len(explanation) <= 3:
            unexplained.append(identifier)
    report.check("journalctl -x explains every MESSAGE_ID that was seen", explained > 0 and not unexplained,
                 f"{explained} explained, without text: {unexplained or 'none'}")
    report.check("and names the bus, device or client that it is about", explained > 0 and not unfilled,
                 f"not filled in: {', '.join(sorted(unfilled)) or 'none'}")
    listed = plant.container.run("journalctl", "--list-catalog").output
    report.told("entries of the catalog by mbgate", sum("mbgate" in line.lower() for line in listed.splitlines()))
