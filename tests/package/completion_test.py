#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bash and zsh offer every long option that --help names, of each program and subcommand; so do the manual pages."""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
PROGRAMS = pathlib.Path(os.environ.get("MBGATE_PROGRAMS", ROOT / "build/asan/bin")).absolute()
PAGES = {"mbgated": "mbgated.8", **{name: f"{name}.1" for name in ("mbgatectl", "mbgate-cert", "mbgate-sim", "mbgate-bench")}}
NAMES = [name for name in PAGES if (PROGRAMS / name).exists()]

BASH = """
. "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
_mbgate "$1"
printf '%s\\n' "${COMPREPLY[@]}"
"""

# A shell in a pseudo-terminal completes what is typed; compadd is told to print what it is given to offer.
ZSH = """
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell 'PS1=; fpath=('${(q)1:h}' $fpath); autoload -Uz compinit; compinit -D -u'
zpty -w shell 'offered() { local -a given; builtin compadd -O given "$@"; builtin print -r -- "offered: $given" }'
zpty -w shell 'compadd() { offered "$@"; builtin compadd "$@" }'
zpty -w shell 'bindkey "^I" complete-word; zle -C complete-word complete-word _all'
zpty -w shell '_all() { _main_complete; print -r -- "the end"; exit }'
zpty -w shell 'path=('${(q)2:h}' $path)'
zpty -w shell 'print ready'
while zpty -r shell line; do [[ $line == ready* ]] && break; done
zpty -n -w shell "${(j: :)@[2,-1]:t}"$'\\t'
while zpty -r shell line; do print -r -- ${line//$'\\r'}; [[ $line == *"the end"* ]] && break; done
"""


def help_of(*command):
    done = subprocess.run([*command, "--help"], check=True, capture_output=True, text=True, timeout=60)
    return done.stdout


def options_in(text):
    """The long options, from the lines that begin with one; --no-x of --x,--no-x{false} too."""
    found = set()
    for line in re.findall(r"^ {2}(-\S+)", text, re.MULTILINE):
        found |= set(re.findall(r"--[a-z][a-z-]*", line))
    return found


def commands_in(text):
    _, _, commands = text.partition("\nSubcommands:\n")
    return re.findall(r"^ {2}([a-z-]+) ", commands, re.MULTILINE)


def calls():
    """Each program, and mbgatectl with each subcommand, as (words, text of --help)."""
    waiting = [[str(PROGRAMS / name)] for name in NAMES]
    while waiting:
        words = waiting.pop()
        text = help_of(*words)
        yield words, text
        waiting += [[*words, command] for command in commands_in(text)]


def bash(*words):
    done = subprocess.run(["bash", "-c", BASH, "bash", ROOT / "debian/completion/bash/mbgated", *words], check=True,
                          capture_output=True, text=True, timeout=60)
    return done.stdout.split()


def zsh(*words):
    """Of each word only what stands behind its last slash is typed."""
    done = subprocess.run(["zsh", "-f", "-c", ZSH, "zsh", ROOT / "debian/completion/zsh/_mbgated", *words], check=False,
                          capture_output=True, text=True, timeout=60, cwd=ROOT / "conf")
    return {word for line in done.stdout.splitlines() for word in line.partition("offered: ")[2].split()}


class Bash(unittest.TestCase):
    def test_offers_each_option(self):
        for words, text in calls():
            self.assertTrue(options_in(text), words)
            self.assertEqual(options_in(text), set(bash(*words, "--")), words)

    def test_offers_each_subcommand(self):
        text = help_of(PROGRAMS / "mbgatectl")
        self.assertTrue({"read", "status", "trace"} <= set(commands_in(text)), text)
        self.assertEqual(commands_in(text), bash(str(PROGRAMS / "mbgatectl"), ""))

    def test_offers_what_certificates_are_for(self):
        self.assertEqual(["ca", "server", "client"], bash(str(PROGRAMS / "mbgate-cert"), ""))

    def test_offers_what_begins_as_typed(self):
        self.assertEqual(["--parity"], bash(str(PROGRAMS / "mbgated"), "--par"))
        self.assertEqual(["coils", "discrete", "holding", "input"], bash(str(PROGRAMS / "mbgatectl"), "read", ""))

    def test_offers_values(self):
        self.assertEqual(["even", "odd", "none"], bash(str(PROGRAMS / "mbgated"), "--parity", ""))
        self.assertEqual(["big"], bash(str(PROGRAMS / "mbgatectl"), "read", "--order", "b"))
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "plant.toml").touch()
            self.assertEqual([f"{folder}/plant.toml"], bash(str(PROGRAMS / "mbgated"), "--config", f"{folder}/pl"))

    def test_offers_names_of_the_configuration(self):
        ctl = str(PROGRAMS / "mbgatectl")
        demo = ("--config", str(ROOT / "conf/demo.toml"))
        self.assertEqual(["line-a", "line-b"], bash(ctl, "doctor", *demo, "--bus", ""))
        self.assertEqual(["axis-x", "axis-y"], bash(ctl, "trace", *demo, "--device", "axis-"))
        self.assertEqual(["demo"], bash(str(PROGRAMS / "mbgated"), *demo, "--listener", ""))

    def test_offers_profiles(self):
        self.assertEqual(["moons-m2", "moons-m3", "moons-mdx"], bash(str(PROGRAMS / "mbgatectl"), "profile", "moons-m"))


class Zsh(unittest.TestCase):
    def test_offers_each_option(self):
        if shutil.which("zsh") is None:
            self.skipTest("zsh is not installed")
        for words, text in calls():
            self.assertEqual(options_in(text), {word for word in zsh(*words, "--") if word.startswith("--")}, words)

    def test_offers_names_of_the_configuration_and_profiles(self):
        if shutil.which("zsh") is None:
            self.skipTest("zsh is not installed")
        ctl, demo = str(PROGRAMS / "mbgatectl"), ("--config", "demo.toml")
        self.assertEqual({"line-a", "line-b"}, zsh(ctl, "doctor", *demo, "--bus", ""))
        self.assertEqual({"axis-x", "axis-y"}, zsh(ctl, "trace", *demo, "--device", "axis-"))
        self.assertLess({"moons-m2", "moons-m3", "moons-mdx"}, zsh(ctl, "profile", "moons-"))


class ManualPages(unittest.TestCase):
    def test_have_each_option(self):
        for words, text in calls():
            page = (ROOT / "debian/man" / PAGES[pathlib.Path(words[0]).name]).read_text(encoding="utf-8")
            plain = page.replace("\\-", "-")
            missing = [option for option in options_in(text) - {"--help", "--version"} if option not in plain]
            self.assertEqual([], missing, words)


if __name__ == "__main__":
    unittest.main()
