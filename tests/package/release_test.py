#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""./dev release in a checkout whose packages are there already, or are not: none is really built here."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
SKIPPED = 77
TOOLS = ("dpkg-deb", "dpkg-parsechangelog", "git")
ARCHITECTURES = ("amd64", "arm64", "armhf")
VERSION = re.search(r"\((.*?)\)", (ROOT / "debian/changelog").read_text(encoding="utf-8")).group(1)
SUITE = re.search(r"^VERSION_CODENAME=(.*)$", pathlib.Path("/etc/os-release").read_text(encoding="utf-8"), re.MULTILINE).group(1)

CONTROL = """Package: mbgate
Version: {version}
Architecture: {arch}
Maintainer: mbgate developers <mbgate@example.org>
Depends: openssl, libc6 (>= 2.34), libssl3 (>= 3.0.0)
Description: stand-in
"""
BUILDINFO = """Format: 1.0
Build-Date: Sun, 29 Nov 2026 10:00:00 +0000
Installed-Build-Depends:
 libboost-dev (= 1.81.0.1),
 libboost1.81-dev:{arch} (= 1.81.0-5+deb12u1),
 libcli11-dev (= 2.1.2+ds-1),
 libssl3 (= 3.0.15-1~deb12u1),
 libtomlplusplus-dev (= 3.3.0+ds-1)
"""


class Checkout:
    def __init__(self, test):
        folder = tempfile.TemporaryDirectory()
        test.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "mbgate"
        self.folder.mkdir()
        for name in ("dev", "CHANGELOG.md", ".gitignore"):
            shutil.copy(ROOT / name, self.folder)
        shutil.copytree(ROOT / "debian", self.folder / "debian", ignore=shutil.ignore_patterns("mbgate", "files", "*.log"))
        self.tools = pathlib.Path(folder.name) / "tools"
        self.tools.mkdir()
        self.add_tool("dpkg-query", "echo installed")
        self.add_tool("dpkg", "echo amd64")
        self.add_tool("mmdebstrap", "exit 1")
        self.add_tool("sudo", "exec \"$@\"")
        self.git("init", "-q")
        self.commit = self.make_commit()

    def add_tool(self, name, does):
        (self.tools / name).write_text(f'#!/bin/bash\necho "{name} $*" >>"{self.tools}/notes"\n{does}\n', encoding="utf-8")
        (self.tools / name).chmod(0o755)

    def git(self, *arguments):
        who = ("-c", "user.name=Test", "-c", "user.email=test@example.org")
        return subprocess.run(["git", *who, *arguments], cwd=self.folder, check=True, stdout=subprocess.PIPE, text=True).stdout

    def make_commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "--allow-empty", "-m", "A version")
        return self.git("rev-parse", "HEAD").strip()

    def add_package(self, arch):
        """As ./dev package leaves it."""
        made = self.folder / f"build/package/{SUITE}-{arch}"
        (made / "tree/DEBIAN").mkdir(parents=True)
        (made / "tree/DEBIAN/control").write_text(CONTROL.format(version=VERSION, arch=arch), encoding="utf-8")
        name = f"mbgate_{VERSION}_{arch}"
        subprocess.run(["dpkg-deb", "--root-owner-group", "-b", made / "tree", made / f"{name}.deb"], check=True,
                       stdout=subprocess.DEVNULL)
        shutil.rmtree(made / "tree")
        (made / f"{name}.buildinfo").write_text(BUILDINFO.format(arch=arch), encoding="utf-8")
        (made / "commit").write_text(self.commit + "\n", encoding="utf-8")

    def release(self):
        done = subprocess.run([self.folder / "dev", "release"], check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, timeout=120, env=os.environ | {"PATH": f"{self.tools}:{os.environ['PATH']}"})
        return done.returncode, done.stdout

    def notes(self):
        return (self.tools / "notes").read_text(encoding="utf-8")


class Release(unittest.TestCase):
    def test_has_packages_lists_of_parts_checksums_and_the_entry_of_the_changelog(self):
        checkout = Checkout(self)
        for arch in ARCHITECTURES:
            checkout.add_package(arch)
        status, said = checkout.release()
        self.assertEqual(0, status, said)
        folder = checkout.folder / f"build/release/{VERSION}"
        wanted = {f"mbgate_{VERSION}_{arch}.{kind}" for arch in ARCHITECTURES for kind in ("deb", "buildinfo", "spdx.json")}
        self.assertEqual(wanted | {"CHANGES.md", "SHA256SUMS"}, {path.name for path in folder.iterdir()})
        subprocess.run(["sha256sum", "--check", "--quiet", "--strict", "SHA256SUMS"], cwd=folder, check=True)
        self.assertEqual(len(wanted) + 1, len((folder / "SHA256SUMS").read_text(encoding="utf-8").splitlines()))
        self.assertTrue((folder / "CHANGES.md").read_text(encoding="utf-8").startswith(f"## [{VERSION}]"))

    def test_builds_only_what_this_commit_has_not(self):
        checkout = Checkout(self)
        for arch in ARCHITECTURES:
            checkout.add_package(arch)
        (checkout.folder / f"build/package/{SUITE}-arm64/commit").write_text("0123\n", encoding="utf-8")
        status, said = checkout.release()
        self.assertNotEqual(0, status)
        self.assertIn("amd64: there is a package of this commit in ", said)
        self.assertNotIn("arm64: there is", said)
        self.assertEqual(1, checkout.notes().count("mmdebstrap --variant=buildd --architectures=amd64,arm64 "), said)
        checkout.add_package("arm64")
        self.assertEqual(0, checkout.release()[0])

    def test_is_of_a_commit(self):
        checkout = Checkout(self)
        (checkout.folder / "CHANGELOG.md").write_text("", encoding="utf-8")
        self.assertEqual((1, "dev: a release is made of a commit: commit what has changed\n"), checkout.release())
        checkout.make_commit()
        status, said = checkout.release()
        self.assertEqual(1, status)
        self.assertIn(f"CHANGELOG.md has no entry for version {VERSION}", said)


class PartsOfAPackage(unittest.TestCase):
    """What SPDX 2.3 requires of a document and of its packages, and what stands in it."""

    def setUp(self):
        checkout = Checkout(self)
        checkout.add_package("arm64")
        made = checkout.folder / f"build/package/{SUITE}-arm64"
        done = subprocess.run([ROOT / "debian/sbom.py", *made.glob("*.deb"), *made.glob("*.buildinfo")], check=True,
                              stdout=subprocess.PIPE)
        self.document = json.loads(done.stdout)

    def test_has_what_the_specification_requires(self):
        document = self.document
        self.assertEqual(("SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT"),
                         tuple(document[key] for key in ("spdxVersion", "dataLicense", "SPDXID")))
        self.assertRegex(document["documentNamespace"], r"^https://[^#]+$")
        self.assertRegex(document["creationInfo"]["created"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        self.assertRegex(document["creationInfo"]["creators"][0], "^(Person|Organization|Tool): .+")
        names = {"SPDXRef-DOCUMENT"}
        for package in document["packages"]:
            self.assertRegex(package["SPDXID"], r"^SPDXRef-[a-zA-Z0-9.-]+$")
            self.assertNotIn(package["SPDXID"], names)
            names.add(package["SPDXID"])
            for key in ("name", "downloadLocation"):
                self.assertTrue(package[key])
        for relation in document["relationships"]:
            self.assertLessEqual({relation["spdxElementId"], relation["relatedSpdxElement"]}, names)

    def test_names_libraries_with_the_versions_of_the_build(self):
        versions = {package["name"]: package.get("versionInfo") for package in self.document["packages"]}
        self.assertEqual({"mbgate": VERSION, "openssl": None, "libc6": None, "libssl3": "3.0.15-1~deb12u1",
                          "libboost1.81-dev": "1.81.0-5+deb12u1", "libcli11-dev": "2.1.2+ds-1",
                          "libtomlplusplus-dev": "3.3.0+ds-1"}, versions)
        compiled_in = {relation["relatedSpdxElement"] for relation in self.document["relationships"]
                       if relation["relationshipType"] == "STATIC_LINK"}
        self.assertEqual({f"SPDXRef-Package-{name}" for name in versions if name.endswith("-dev")}, compiled_in)


if __name__ == "__main__":
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    if missing:
        print(f"skipped: {', '.join(missing)} not installed")
        sys.exit(SKIPPED)
    unittest.main()
