# SPDX-License-Identifier: Apache-2.0
"""Modbus/TCP Security as the package has it: certificates by mbgate-cert, the key with the signer alone, one rule for a role."""

from plant import AXIS, BASE, REGISTER

FOLDER = "/root/ca"
SECURE_PORT = 1802
SECURE = f"""
[[tls]]
name = "plant"
certificate = "certs/gateway.crt"
key = "gateway.key"
authorities = "certs/ca.crt"
crl = "certs/ca.crl"

[[listen]]
name = "secure"
address = "127.0.0.1"
port = {SECURE_PORT}
tls = "plant"

[[rule]]
name = "operators-read"
listeners = ["secure"]
roles = ["Operator"]
access = "read"
action = "permit"
"""


def make_certificates(container):
    container.must("mkdir", "-p", FOLDER)
    container.must("mbgate-cert", "ca", "--directory", FOLDER)
    container.must("mbgate-cert", "server", "--directory", FOLDER, "gateway", "--address", "127.0.0.1")
    container.must("mbgate-cert", "client", "--directory", FOLDER, "panel", "--role", "Operator")
    container.must("mbgate-cert", "client", "--directory", FOLDER, "guest")
    for name in ("gateway.crt", "ca.crt", "ca.crl"):
        container.must("install", "-m", "644", f"{FOLDER}/{name}", "/etc/mbgate/certs/")
    container.must("install", "-o", "root", "-g", "mbgate-tls", "-m", "640", f"{FOLDER}/gateway.key", "/etc/mbgate/tls/")


def asked(container, what, client, *values):
    return container.run(
        "mbgatectl", what, "--tls", "--host", "127.0.0.1", "--port", str(SECURE_PORT), "--certificate",
        f"{FOLDER}/{client}.crt", "--key", f"{FOLDER}/{client}.key", "--authorities", f"{FOLDER}/ca.crt",
        "--unit", str(AXIS), "holding", str(REGISTER), *values)


def security(plant):
    report, container = plant.report, plant.container
    plant.fresh()
    make_certificates(container)
    plant.configure(BASE + SECURE)
    plant.systemctl("start", "mbgated.socket")
    done = plant.systemctl("start", "mbgated")
    report.check("a listener with TLS starts, its signer by its socket", done, done or plant.journal())
    read = asked(container, "read", "panel")
    report.check("the role may read", read, read)
    written = asked(container, "write", "panel", "5")
    report.check("and not write: exception 01", not written and "01" in written.output, written)
    guest = asked(container, "read", "guest")
    report.check("the NULL role may nothing: exception 01", not guest and "01" in guest.output, guest)
    users = [
        container.run("runuser", "-u", user, "--", "head", "-c", "1", "/etc/mbgate/tls/gateway.key")
        for user in ("mbgate", "mbgate-tls")
    ]
    report.check("the user of mbgated cannot open the key, that of the signer can", not users[0] and users[1],
                 "; ".join(map(str, users)))
    score = container.run("systemd-analyze", "security", "--no-pager", "mbgate-signer.service").output
    report.check("systemd-analyze security of the signer", "Overall exposure" in score, score.strip().splitlines()[-1])
    plant.fresh()
