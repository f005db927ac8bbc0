#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The documents of the source tree link to what is there, and name keys and commands that exist."""

import importlib.machinery
import importlib.util
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).parents[2]
# What operators read. metrics, recording and linked-libraries are held to the programs by tests of their own.
GUIDES = [ROOT / "README.md", ROOT / "SECURITY.md"] + [
    ROOT / f"docs/{name}.md" for name in ("access-rules", "behaviour", "drives", "hardening", "installing", "status",
                                          "tls", "troubleshooting")]
OTHERS = {"dialout", "false", "mbgate", "mbgatectl", "mbgated", "mbpoll", "plant", "timedatectl", "true"}


def text_of(path):
    return (ROOT / path).read_text(encoding="utf-8")


def the_test_of_the_package():
    loader = importlib.machinery.SourceFileLoader("documents", str(ROOT / "debian/tests/documents"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("documents", loader))
    loader.exec_module(module)
    return module


def keys():
    """Of the configuration, all of which conf/mbgate.toml has, and of profiles."""
    profiles = text_of("conf/profiles/README.md")
    columns = "".join(re.findall(r"^\| (`[^|]*)\|", profiles, re.MULTILINE))
    return (set(re.findall(r"(?:^|^# |[{,] )([a-z]\w*) = ", text_of("conf/mbgate.toml"), re.MULTILINE)) |
            set(re.findall(r"(\w+) = ", profiles)) | set(re.findall(r"`\[?(\w+)\]?`", columns)))


def commands():
    sources = (ROOT / "src/ctl/options").glob("*.cpp")
    return set(re.findall(r'add_subcommand\(\s*"([a-z-]+)"', "".join(source.read_text(encoding="utf-8")
                                                                    for source in sources)))


def code_in(text):
    """The blocks of code, and the words in backticks outside of them."""
    fence = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
    return fence.findall(text), re.findall(r"`([^`]+)`", fence.sub("", text))


class SourceDocuments(unittest.TestCase):
    def test_link_to_what_is_there(self):
        documents = sorted(ROOT.glob("*.md"))
        for folder in ("bench", "conf", "docs", "src", "tests"):
            documents += sorted((ROOT / folder).rglob("*.md"))
        wrong_links = the_test_of_the_package().wrong_links
        self.assertEqual([], [f"{document.relative_to(ROOT)}: {link}" for document in documents
                              for link in wrong_links(document)])

    def test_name_keys_and_commands_that_exist(self):
        known_commands = commands()
        known = keys() | known_commands | OTHERS
        self.assertGreater(len(known), 150)
        wrong = []
        for guide in GUIDES:
            blocks, words = code_in(guide.read_text(encoding="utf-8"))
            named = [match[1] for word in words if (match := re.fullmatch(r"([a-z]\w*)(?: = .*)?", word))]
            named += [key for block in blocks for key in re.findall(r"^([a-z]\w*) = ", block, re.MULTILINE)]
            wrong += [f"{guide.name}: {key}" for key in named if key not in known and not key.startswith("mbgate_")]
            asked = re.findall(r"(?<![/:])\bmbgatectl\s+([a-z][a-z-]*)", "|".join(blocks + words))
            wrong += [f"{guide.name}: mbgatectl {word}" for word in asked if word not in known_commands]
        self.assertEqual([], wrong)


class Version(unittest.TestCase):
    def test_is_the_same_everywhere(self):
        version = re.search(r"project\(mbgate VERSION (\S+)", text_of("CMakeLists.txt")).group(1)
        self.assertTrue(text_of("debian/changelog").startswith(f"mbgate ({version}) "))
        self.assertTrue(text_of("debian/NEWS").startswith(f"mbgate ({version}) "))
        self.assertIn(f"\n## [{version}]", text_of("CHANGELOG.md"))
        for page in (ROOT / "debian/man").glob("*.[158]"):
            self.assertIn(f'"mbgate {version}"', page.read_text(encoding="utf-8"), page.name)


if __name__ == "__main__":
    unittest.main()
