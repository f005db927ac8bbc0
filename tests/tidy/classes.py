#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""No class of the pure modules has more member functions, or more sources, than a reader keeps in mind.

Every declaration counts: each overload, constructors, operators, static functions and templates. What is deleted does not, nor
what is a friend's; a class within another counts for itself. No compiler is asked: brackets are taken away from the inside
outwards, until what is left of a class is the list of its declarations. Sources are those with bodies outside of the class.
usage: classes.py [FOLDER], FOLDER holding src/.
"""

import re
import sys

sys.dont_write_bytecode = True

import arrows  # noqa: E402  (nothing is written beside it)

MOST_MEMBERS = 25
MOST_SOURCES = 2

# Comments, strings, characters (' also separates digits), lines of the preprocessor.
NO_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"([^(\s]*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:\\\n|[^\n])*',
    re.DOTALL | re.MULTILINE)
# Braces without others inside, and what stands before them.
BLOCK = re.compile(r"([^;{}]*)\{([^{}]*)\}")
HEAD = re.compile(r"(?<!\benum\s)\b(?:class|struct|union)\b([^;=()@]*?)(?:\s*\bfinal)?\s*(?<!:)(?::(?!:)[^;()@]*)?$")
# Each is taken out again and again, in this order. @ is a block.
REDUCTIONS = tuple((re.compile(pattern), left) for pattern, left in (
    (r"\boperator\s*(?:\(\s*\)|[^\s\w(]+)", "named"),
    (r"\[\[.*?\]\]|->", " "),
    (r"\((?:[^()]|\(\))+\)", "()"),
    (r"<[^<>;]*>", " "),
    (r"\b(?:alignas|decltype|explicit|noexcept|requires)\s*\(\)", " "),
    (r"\b(?:public|protected|private)\s*:(?!:)", ""),
    (r"\)\s*:\s*[\w:]+\s*(?:@|\(\))(?:\s*,\s*[\w:]+\s*(?:@|\(\)))*", ")"),  # what a constructor initializes
    (r"=\s*delete\s*;", "deleted;"),
    (r"=[^;]+;", ";"),
    (r"\)([^;()@]*)@", r")\1;"),  # the body of a function ends its declaration
))
NO_MEMBER = re.compile(r"\b(?:friend|using|typedef|static_assert|deleted)\b")
# Of a member function, outside of its class: it is not indented.
DEFINITION = re.compile(r"^(?=\S)[^({\n]*?\b(\w+)::(?:~?\w+|operator[^\s\w]+)\(", re.MULTILINE)


def members_of(body):
    """How many member functions are declared in the body of a class, in which there are no braces any more."""
    for pattern, left in REDUCTIONS:
        reductions = 1
        while reductions > 0:
            body, reductions = pattern.subn(left, body)
    return sum("(" in declaration and not NO_MEMBER.search(declaration) for declaration in body.split(";"))


def classes_of(text):
    """All classes that a source defines, the inner ones first: pairs of a name and the number of member functions."""
    found = []

    def close(block):
        head = HEAD.search(block[1])
        if head:
            found.append((head[1].strip() or "without a name", members_of(block[2])))
        return block[1] + "@"

    text, blocks = BLOCK.subn(close, NO_CODE.sub(" ", text))
    while blocks > 0:
        text, blocks = BLOCK.subn(close, text)
    return found


def check_tree(root):
    """All findings about the pure modules of src/ below `root`, and how many classes were looked at."""
    found, classes, sources = [], set(), {}
    for module in sorted(arrows.PURE_MODULES):
        for file in sorted((root / "src" / module).rglob("*.?pp")):
            path, text = file.relative_to(root).as_posix(), file.read_text(encoding="utf-8")
            for name, members in classes_of(text):
                classes.add((module, name))
                if members > MOST_MEMBERS:
                    found.append(f"{path}: class {name} has {members} member functions, more than {MOST_MEMBERS}")
            for name in DEFINITION.findall(NO_CODE.sub(" ", text)):
                sources.setdefault((module, name), set()).add(path)
    for (module, name), paths in sorted(sources.items()):
        if (module, name) in classes and len(paths) > MOST_SOURCES:
            found.append(f"src/{module}: class {name} has bodies in {len(paths)} sources, more than {MOST_SOURCES}: "
                         f"{', '.join(sorted(paths))}")
    return found, len(classes)


def main():
    return arrows.report(check_tree, "classes")


if __name__ == "__main__":
    sys.exit(main())
