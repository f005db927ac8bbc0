#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes mbgate.toml(5): the words of conf/mbgate.toml, and what `mbgated --keys` says that each plain key takes.

usage: config_page.py [--check] MBGATED

Writes debian/man/mbgate.toml.5. --check only compares, and exits 1 if the page is not what it would be.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "debian/man/mbgate.toml.5"

TITLE = re.compile(r"#? ?(\[\[?[a-z_.]+\]\]?)$")
HEADING = re.compile(r"# --- (.*?) -+$")
KEY = re.compile(r"#? ?([a-z0-9_]+) = (.*)$")
CONTINUED = re.compile(r" {20,}# ?(.*)$")

HEAD = r""".\" SPDX-License-Identifier: Apache-2.0
.\" Made by debian/man/config_page.py from conf/mbgate.toml and mbgated --keys.
.TH MBGATE.TOML 5 "" "mbgate 0.2.0" "File Formats"
.SH NAME
mbgate.toml \- configuration of mbgated
.SH DESCRIPTION
"""

FOOT = r""".SH FILES
.TP
.I /etc/mbgate/mbgate.toml
The configuration.
.TP
.I /etc/mbgate/conf.d/*.toml
More of it; see
.BR mbgated (8).
.TP
.I /etc/mbgate/profiles
Profiles of your own.
.SH SEE ALSO
.BR mbgate\-profile (5),
.BR mbgated (8),
.BR mbgatectl (1)
"""


def value_and_comment(text):
    """`"a"  # why` apart: a # within quotes begins no comment."""
    quoted = False
    for at, letter in enumerate(text):
        quoted ^= letter == '"'
        if letter == "#" and not quoted:
            return text[:at].rstrip(), text[at + 1:].strip()
    return text.rstrip(), ""


class Section:
    def __init__(self, title):
        self.title = title
        self.lead = []  # paragraphs
        self.keys = {}  # name: [value, words]


def read(text):
    """The introduction, and the sections in the order of the file. Of a key that stands twice the first counts; what is said
    above a section that adds no key is of an example, and left out."""
    introduction, sections = [], {}
    section, key = Section(""), None
    paragraph, above = [], introduction

    def end_paragraph():
        if paragraph:
            above.append(" ".join(paragraph))
            paragraph.clear()

    for line in text.splitlines()[1:]:
        title, found, more = (pattern.match(line) for pattern in (TITLE, KEY, CONTINUED))
        if HEADING.match(line):
            end_paragraph()
            above, key = [], None
        elif title:
            end_paragraph()
            section, key = sections.setdefault(title.group(1), Section(title.group(1))), None
            said, above = (above if above is not introduction else []), []
        elif more and key:
            key[1] = f"{key[1]} {more.group(1)}".strip()
        elif found and section.title:
            value, words = value_and_comment(found.group(2))
            key = [value, " ".join([*paragraph, words]).strip()]
            paragraph.clear()
            if section.keys.setdefault(found.group(1), key) is key:
                section.lead += said
                said = []
        elif line.strip("# "):
            paragraph.append(line.strip("# "))
        else:
            end_paragraph()
    return introduction, sections.values()


def roff(text):
    escaped = text.replace("\\", r"\e").replace("-", r"\-")
    return r"\&" + escaped if escaped[:1] in (".", "'") else escaped


def sentences(text):
    """One a line, as roff wants it."""
    return re.sub(r"(?<=[.;]) (?=[A-Za-z\"])|(?<=:) (?=[A-Z\"])", "\n", text)


def paragraph_of(text):
    return "\n".join(roff(line) for line in sentences(text).split("\n"))


def closed(text):
    """A sentence of its own, so that another may follow. A value stays as it is written."""
    begins = text if text.startswith(("true", "false")) else text[:1].upper() + text[1:]
    return begins + ("" if text.endswith((".", ":")) else ".")


def entry(name, key, takes):
    value, words = key
    if takes and takes[0] != "true or false":
        words = f"{closed(words)} {closed(takes[0])}"
    if takes and takes[1] != "everywhere":
        words = f"{closed(words)} Belongs to {takes[1]}."
    return f".TP\n\\fB{roff(name)}\\fR = {roff(value)}\n{paragraph_of(closed(words))}\n"


def page(text, keys):
    introduction, sections = read(text)
    out = HEAD + "\n.PP\n".join(map(paragraph_of, introduction)) + "\n"
    for section in sections:
        out += f".SH {roff(section.title)}\n" + "\n.PP\n".join(map(paragraph_of, section.lead)) + "\n"
        for name, key in section.keys.items():
            out += entry(name, key, keys.get((section.title, name)))
    return out.replace("\n\n", "\n") + FOOT


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--check"]
    if len(arguments) != 1:
        sys.exit(__doc__.splitlines()[2])
    listed = subprocess.run([arguments[0], "--keys"], check=True, stdout=subprocess.PIPE, text=True).stdout
    keys = {}
    for line in listed.splitlines():
        title, name, takes, _, lines = line.split("\t")
        keys[title, name] = takes, lines
    made = page((ROOT / "conf/mbgate.toml").read_text(encoding="utf-8"), keys)
    if "--check" not in sys.argv[1:]:
        PAGE.write_text(made, encoding="utf-8")
    elif not PAGE.exists() or PAGE.read_text(encoding="utf-8") != made:
        sys.exit("debian/man/mbgate.toml.5 is not what it should be; make it again: debian/man/config_page.py MBGATED")


if __name__ == "__main__":
    main()
