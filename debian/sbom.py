#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What a package is made of and needs, as SPDX 2.3 in JSON, on standard output.

usage: sbom.py PACKAGE.deb PACKAGE.buildinfo

The libraries that it needs are those of its Depends; of Boost, toml++ and CLI11 the headers are compiled into the programs.
Versions are those that it was built with, which the .buildinfo names.
"""

import datetime
import email.utils
import hashlib
import json
import pathlib
import re
import subprocess
import sys

# Libraries whose headers are compiled into the programs: package of Debian, and licence.
HEADERS = {r"libboost[\d.]*-dev": "BSL-1.0", "libtomlplusplus-dev": "MIT", "libcli11-dev": "BSD-3-Clause"}


def field(text, name):
    """A field of a control file, in one line; empty if there is none."""
    found = re.search(rf"^{name}: *(.*(?:\n .*)*)", text, re.MULTILINE)
    return " ".join(found.group(1).split()) if found else ""


def entry(name, version, arch, **more):
    """A package of SPDX."""
    identity = re.sub(r"[^a-zA-Z0-9.-]", "-", name)
    versioned = f"@{version.replace('+', '%2B').replace(':', '%3A')}" if version else ""
    return {
        "name": name,
        "SPDXID": f"SPDXRef-Package-{identity}",
        **({"versionInfo": version} if version else {}),
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": "NOASSERTION",
        "licenseDeclared": "NOASSERTION",
        "copyrightText": "NOASSERTION",
        "externalRefs": [{
            "referenceCategory": "PACKAGE-MANAGER",
            "referenceType": "purl",
            "referenceLocator": f"pkg:deb/debian/{name}{versioned}?arch={arch}",
        }],
        **more,
    }


def document(deb, buildinfo):
    control = subprocess.run(["dpkg-deb", "-f", deb], check=True, stdout=subprocess.PIPE, text=True).stdout
    name, version, arch = (field(control, key) for key in ("Package", "Version", "Architecture"))
    built_with = dict(re.findall(r"([a-z0-9.+-]+)(?::\w+)? \(= ([^)]+)\)", field(buildinfo, "Installed-Build-Depends")))
    needed = [re.match(r"[a-z0-9.+-]+", one.strip()).group() for one in field(control, "Depends").split(",") if one.strip()]
    headers = {library: licence for pattern, licence in HEADERS.items()
               for library in built_with if re.fullmatch(pattern, library) and library != "libboost-dev"}
    digest = hashlib.sha256(pathlib.Path(deb).read_bytes()).hexdigest()
    ours = entry(name, version, arch, licenseDeclared="Apache-2.0", packageFileName=pathlib.Path(deb).name,
                 supplier="Person: " + re.sub(r" <(.*)>", r" (\1)", field(control, "Maintainer")),
                 checksums=[{"algorithm": "SHA256", "checksumValue": digest}])
    others = [(entry(library, built_with.get(library, ""), arch), "DEPENDS_ON") for library in needed]
    others += [(entry(library, built_with[library], arch, licenseDeclared=licence), "STATIC_LINK")
               for library, licence in headers.items()]
    begun = email.utils.parsedate_to_datetime(field(buildinfo, "Build-Date")).astimezone(datetime.timezone.utc)
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"{name}_{version}_{arch}",
        "documentNamespace": f"https://spdx.org/spdxdocs/{name}_{version}_{arch}-{digest}",
        "creationInfo": {"created": begun.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: debian/sbom.py"]},
        "packages": [ours, *(other for other, _ in others)],
        "relationships": [
            {"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": ours["SPDXID"]},
            *({"spdxElementId": ours["SPDXID"], "relationshipType": kind, "relatedSpdxElement": other["SPDXID"]}
              for other, kind in others),
        ],
    }


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__.splitlines()[2])
    json.dump(document(sys.argv[1], pathlib.Path(sys.argv[2]).read_text(encoding="utf-8")), sys.stdout, indent=2)
    print()


if __name__ == "__main__":
    main()
