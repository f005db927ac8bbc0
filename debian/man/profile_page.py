#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes mbgate-profile(5) of conf/profiles/README.md, which has the table of the keys of a profile.

usage: profile_page.py [--check]

Writes debian/man/mbgate-profile.5. --check only compares, and exits 1 if the page is not what it would be.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "debian/man/mbgate-profile.5"

HEAD = r""".\" SPDX-License-Identifier: Apache-2.0
.\" Made by debian/man/profile_page.py from conf/profiles/README.md.
.TH MBGATE-PROFILE 5 "" "mbgate 0.2.0" "File Formats"
.SH NAME
mbgate\-profile \- drive profiles of mbgated
.SH DESCRIPTION
"""

FOOT = r""".SH FILES
.TP
.I /etc/mbgate/profiles/*.toml
Profiles of your own.
.TP
.I /usr/share/mbgate/profiles/*.toml
The profiles that come with mbgate.
.SH SEE ALSO
.BR mbgatectl (1),
.BR mbgate.toml (5),
.BR mbgated (8)
"""


def escape(text):
    return text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("–", "\\(en").replace("−", "\\-")


def inline(text):
    """Words with `code`, **bold** and [links](to)."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    parts = re.split(r"(`[^`]*`|\*\*.*?\*\*)", text)
    return "".join(f"\\fB{escape(part.strip('`*'))}\\fR" if part.startswith(("`", "**")) else escape(part)
                   for part in parts)


def lines_of(text):
    """A sentence a line; none begins with what troff takes for a request."""
    for line in re.sub(r"(?<=[.:?!]) (?=[A-Z\\])", "\n", text).split("\n"):
        yield ("\\&" if line.startswith((".", "'")) else "") + line


def table_row(cells, names):
    """A row of a table: the first cell, and the others with what they are, where that is to be said."""
    yield ".TP"
    yield inline(cells[0]) or "\\&"
    words = [cells[1]] if len(cells) > 1 else []
    words += [f"{name.capitalize()}: {cell}" for name, cell in zip(names[2:], cells[2:]) if cell not in ("", "–")]
    yield from lines_of(inline(". ".join(words) + "."))


def cells_of(line):
    return [cell.strip() for cell in line.strip().strip("|").split(" | ")]


def columns(table):
    """A table as it is, without marks: its columns below each other."""
    table = [[cell.replace("`", "") for cell in cells] for cells in table]
    widths = [max(len(cells[i]) for cells in table if i < len(cells)) for i in range(len(table[0]))]
    return ["  ".join(cell.ljust(width) for cell, width in zip(cells, widths)).rstrip() for cells in table]


def code(rows, gap):
    return [*gap, ".RS", ".EX", *(("\\&" if row.startswith((".", "'")) else "") + escape(row) for row in rows), ".EE", ".RE"]


def block(rows):
    """What rows between two blank lines become."""
    first = rows[0]
    if first.startswith("## "):
        return [f".SH {escape(first[3:]).upper()}"]
    if first.startswith("# "):
        return []
    if first.startswith("```"):
        return code(rows[1:-1], [".PP"])
    if first.startswith("|"):
        names = cells_of(first)
        if not names[0] or names[0] == "line":
            return code(columns([names, *map(cells_of, rows[2:])]), [".PP"])
        return [line for row in rows[2:] for line in table_row(cells_of(row), names)]
    if re.match(r"\d+\. ", first):
        items = re.split(r"\n(?=\d+\. )", "\n".join(rows))
        made = []
        for item in items:
            number, words = item.split(" ", 1)
            made += [f".IP {number} 4", *lines_of(inline(re.sub(r"\s*\n\s*", " ", words)))]
        return made
    words = " ".join(row.removeprefix("> ").strip() for row in rows)
    return [".PP", *lines_of(inline(words))]


def blocks(text):
    """Rows that belong together; code keeps its blank lines."""
    rows, fenced = [], False
    for row in text.splitlines():
        if row.startswith("```"):
            fenced = not fenced
        if row or fenced:
            rows.append(row)
        elif rows:
            yield rows
            rows = []
    if rows:
        yield rows


def make_page():
    made = []
    for rows in blocks((ROOT / "conf/profiles/README.md").read_text(encoding="utf-8")):
        made += block(rows)
    body = re.sub(r"(^|\n)(\.SH [^\n]*)\n\.PP\n", r"\1\2\n", "\n".join(made[1:] if made[0] == ".PP" else made))
    return HEAD + body + "\n" + FOOT


def main():
    page = make_page()
    if sys.argv[1:] == ["--check"]:
        if PAGE.read_text(encoding="utf-8") != page:
            print("debian/man/mbgate-profile.5 is not what conf/profiles/README.md says: debian/man/profile_page.py makes it")
            return 1
        return 0
    if sys.argv[1:]:
        print(__doc__)
        return 2
    PAGE.write_text(page, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
