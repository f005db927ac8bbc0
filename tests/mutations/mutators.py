# SPDX-License-Identifier: Apache-2.0
"""Where C++ can be changed by one small step, and how it reads then: as somebody would have written the error,
and behind a switch, so that one program holds many of them. The places are found by libclang (python3-clang-19)."""

import pathlib
import re
from typing import NamedTuple

try:
    from clang import cindex
    from clang.cindex import CursorKind as Kind
except ImportError:
    cindex = None

MUTATORS = ("drop", "negate", "shift", "exchange", "return")
HEADER = pathlib.Path(__file__).with_name("mutation.hpp")
# What is said for people alone, and what only shows the state to tests.
LEFT_OUT = re.compile(r"^src/gateway/(trace|status)/|/describe\.|text\.[ch]pp$|/event\.hpp$|_reader\.hpp$")


class Mutant(NamedTuple):
    """A piece of a file, in bytes, and what becomes of it."""

    file: str
    start: int
    end: int
    mutator: str
    detail: object  # by how much it shifts; the name that a condition declares; two arguments; what return says
    switch: str  # what asks whether a mutant is switched on, here


class Source:
    """The text of one file, and its mutants."""

    def __init__(self, text):
        self.text = text

    def piece(self, start, end):
        return self.text[start:end].decode()

    def line_of(self, offset):
        return self.text.count(b"\n", 0, offset) + 1

    def plain(self, mutant):
        """The piece as somebody would have written the error."""
        inner = self.piece(mutant.start, mutant.end)
        match mutant.mutator:
            case "drop":
                return ""
            case "negate":
                return f"{inner}; !{mutant.detail}" if mutant.detail else f"!({inner})"
            case "shift":
                digits = re.match(r"(0x)?([0-9a-fA-F]+)([uUlLzZ]*)$", inner.replace("'", ""))
                if not digits:
                    return f"({inner} {'+-'[mutant.detail < 0]} 1)"
                base, number, suffix = digits.groups()
                value = int(number, 16 if base else 10) + mutant.detail
                return (f"0x{value:02X}" if base else str(value)) + suffix
            case "exchange":
                return self.exchanged(mutant, lambda start, end: self.piece(start, end))
            case "return":
                return f"{{ return{mutant.detail}; "

    @staticmethod
    def exchanged(mutant, written):
        """The call with its two arguments in the other order."""
        first, second = mutant.detail
        return (written(mutant.start, first[0]) + written(*second) + written(first[1], second[0]) + written(*first)
                + written(second[1], mutant.end))

    def switched(self, numbered):
        """The whole text with all of these in it, each as it was until its number is switched on; lines stay lines."""
        ordered = sorted(numbered, key=lambda it: (it[1].start, -it[1].end, it[0]))

        def written(start, end, among):
            result, at = "", start
            inside = [it for it in among if start <= it[1].start and it[1].end <= end]
            while inside:
                number, mutant = inside[0]
                children = [it for it in inside[1:] if it[1].end <= mutant.end]
                inside = [it for it in inside[1:] if it[1].end > mutant.end]
                result += self.piece(at, mutant.start) + switch(number, mutant, children)
                at = mutant.end
            return result + self.piece(at, end)

        def switch(number, mutant, children):
            inner = written(mutant.start, mutant.end, children)
            it = f"::mbgate::mutation::{mutant.switch}({number})"
            match mutant.mutator:
                case "drop":
                    return f"({it} ? static_cast<void>(0) : static_cast<void>({inner}))"
                case "negate":
                    return (f"{inner}; {it} != static_cast<bool>({mutant.detail})" if mutant.detail
                            else f"({it} != static_cast<bool>({inner}))")
                case "shift":
                    return f"static_cast<decltype({inner} + 0)>({inner} {'+-'[mutant.detail < 0]} {it})"
                case "exchange":
                    other = self.exchanged(mutant, lambda start, end: written(start, end, children)).replace("\n", " ")
                    return f"({it} ? {other} : {inner})"
                case "return":
                    return f"{{ if ({it}) {{ return{mutant.detail}; }}"

        begin, rest = written(0, len(self.text), ordered).split("\n", 1)  # instead of the line of the licence
        assert begin.startswith("//"), begin
        return f'#include "{HEADER.name}"\n{rest}'


FUNCTIONS = {} if cindex is None else {Kind.FUNCTION_DECL, Kind.CXX_METHOD, Kind.CONSTRUCTOR, Kind.DESTRUCTOR,
                                       Kind.CONVERSION_FUNCTION, Kind.FUNCTION_TEMPLATE}
SCOPES = {} if cindex is None else {Kind.NAMESPACE, Kind.CLASS_DECL, Kind.STRUCT_DECL, Kind.CLASS_TEMPLATE,
                                    Kind.CLASS_TEMPLATE_PARTIAL_SPECIALIZATION, Kind.UNEXPOSED_DECL, Kind.LINKAGE_SPEC}
# Whose arguments have no order, or those of equal rank none that is seen.
SYMMETRIC = re.compile(r"(\w+::)*(min|max|equal|swap|earlier|later)\b")
INTEGERS = {"bool", "char", "signed char", "short", "int", "long", "unsigned char", "unsigned short", "unsigned int",
            "unsigned long"}


def span_of(cursor):
    return cursor.extent.start.offset, cursor.extent.end.offset


def type_of(cursor):
    """Without const and references."""
    kind = cursor.type.get_canonical()
    name = (kind.get_pointee() if "&" in kind.spelling[-2:] else kind).spelling
    return re.sub(r"^const ", "", name)


class Finder:
    """Walks through the functions of one file of a translation unit."""

    def __init__(self, file, source, macros):
        self.file, self.source, self.macros = file, source, macros
        self.found = {}
        self.names = set()  # where a name is declared: Name name(a, b), or : member_(a, b)
        self.switch = "on"

    def add(self, cursor, mutator, detail=None, span=None):
        start, end = span or span_of(cursor)
        if end <= start or any(begin < end and start < over for begin, over in self.macros):
            return
        mutant = Mutant(self.file, start, end, mutator, detail, self.switch)
        self.found[mutant[:5]] = mutant

    def text(self, cursor):
        return self.source.piece(*span_of(cursor))

    def function(self, cursor):
        children = list(cursor.get_children())
        body = next((it for it in children if it.kind == Kind.COMPOUND_STMT), None)
        if body is None or "string" in cursor.result_type.spelling:
            return  # declared only, or words for people
        head = self.source.piece(cursor.extent.start.offset, body.extent.start.offset)
        if re.search(r"\bconsteval\b", head):
            return
        self.switch = "is" if re.search(r"\bconstexpr\b", head) else "on"
        result = cursor.result_type.spelling
        if next(body.get_children(), None) and "auto" not in result and cursor.kind != Kind.DESTRUCTOR:
            detail = "" if result == "void" or cursor.kind == Kind.CONSTRUCTOR else " {}"
            self.add(body, "return", detail, (body.extent.start.offset, body.extent.start.offset + 1))
        for child in children:
            if child.kind in (Kind.MEMBER_REF, Kind.TYPE_REF):
                self.names.add(child.extent.start.offset)
            elif child.kind == Kind.COMPOUND_STMT or child.kind.is_expression():
                self.walk(child)

    def walk(self, cursor):
        children = list(cursor.get_children())
        text = self.text(cursor)
        skipped = None
        match cursor.kind:
            case Kind.COMPOUND_STMT | Kind.CASE_STMT | Kind.DEFAULT_STMT:
                skipped = children[0] if cursor.kind == Kind.CASE_STMT else None
                for child in children:
                    if child.kind.is_expression() and child is not skipped:
                        self.add(child, "drop")
            case Kind.IF_STMT if re.match(r"if\s+constexpr", text):
                skipped = children[0]
            case Kind.IF_STMT | Kind.WHILE_STMT:
                self.condition(cursor, children)
            case Kind.FOR_STMT:
                for child in children:
                    if child.kind.is_expression() and type_of(child) == "bool":
                        self.add(child, "negate")
            case Kind.CONDITIONAL_OPERATOR:
                self.add(children[0], "negate")
            case Kind.RETURN_STMT if children and type_of(children[0]) == "bool":
                self.add(children[0], "negate")
            case Kind.BINARY_OPERATOR if len(children) == 2:
                operator = self.source.piece(children[0].extent.end.offset, children[1].extent.start.offset).strip()
                for child in children if operator in ("&&", "||") else []:
                    self.add(child, "negate")
            case Kind.INTEGER_LITERAL if self.is_plain(cursor, text):
                for by in (1, -1) if re.search("[1-9a-fA-F]", text[1:] if text.startswith("0x") else text) else (1,):
                    self.add(cursor, "shift", by)
            case Kind.DECL_REF_EXPR if re.match(r"k[A-Z]\w*$", text) and type_of(cursor) in INTEGERS:
                for by in (1, -1):
                    self.add(cursor, "shift", by)
            case Kind.CALL_EXPR:
                self.call(cursor, text)
            case Kind.VAR_DECL if re.search(r"\bconstexpr\b", text.split("=")[0]):
                return
            case Kind.VAR_DECL if "[" in cursor.type.spelling:
                children = [it for it in children if it.kind != Kind.INTEGER_LITERAL]
            case Kind.STATIC_ASSERT | Kind.TYPE_REF | Kind.TEMPLATE_REF | Kind.PARM_DECL | Kind.TYPE_ALIAS_DECL:
                return
        if cursor.kind == Kind.VAR_DECL:
            self.names.add(cursor.location.offset)
        for child in children:
            if child is not skipped:
                self.walk(child)

    def condition(self, cursor, children):
        """Of an if or a while: what stands in front of its first statement. What it declares may be asked in an if."""
        is_body = [it.kind.is_statement() and it.kind != Kind.DECL_STMT for it in children]
        before = children[:is_body.index(True)] if True in is_body else []
        declared = [it for it in before if it.kind == Kind.VAR_DECL]
        conditions = [it for it in before if it.kind.is_expression()]
        if declared and cursor.kind == Kind.IF_STMT:
            self.add(declared[0], "negate", declared[0].spelling)
        elif conditions and not declared:
            self.add(conditions[-1], "negate")

    def is_plain(self, cursor, text):
        """No argument of a template, no tick of a clock, which nobody sees, and no other notation."""
        before = self.source.piece(cursor.extent.start.offset - 9, cursor.extent.start.offset)
        return (not before.endswith(("<", "Duration{", "Instant{"))
                and re.match(r"(0x)?[0-9a-fA-F']+[uUlLzZ]*$", text) is not None)

    def call(self, cursor, text):
        """Arguments that may stand for each other."""
        if SYMMETRIC.match(text) or cursor.extent.start.offset in self.names:
            return
        arguments = [it for it in cursor.get_arguments() if it is not None and self.text(it)]
        for pair in zip(arguments, arguments[1:]):
            spans = tuple(map(span_of, pair))
            kinds = {type_of(it) for it in pair}
            if ((len(kinds) == 1 or kinds <= INTEGERS) and self.text(pair[0]) != self.text(pair[1])
                    and self.source.piece(spans[0][1], spans[1][0]).strip() == ","):
                self.add(cursor, "exchange", spans)


def read(text, arguments):
    """A translation unit that need not be a file, but includes them."""
    options = cindex.TranslationUnit.PARSE_DETAILED_PROCESSING_RECORD
    return cindex.Index.create().parse("all.cpp", args=arguments, unsaved_files=[("all.cpp", text)], options=options)


def errors_in(unit):
    """What libclang does not understand, as the words of a compiler; before an error what led it there."""
    lines = []
    for wrong in unit.diagnostics:
        if wrong.severity >= cindex.Diagnostic.Error:
            lines += [(note.location, "required from here") for note in wrong.children if note.location.file]
            lines.append((wrong.location, f"error: {wrong.spelling}"))
    return "".join(f"{at.file}:{at.line}:{at.column}: {text}\n" for at, text in lines)


def places(text, root, wanted, arguments):
    """All places in the wanted files (paths below the root) that the text includes."""
    unit = read(text, arguments)
    if errors_in(unit):
        raise SyntaxError(f"libclang does not understand the sources: {errors_in(unit)[:1000]}")
    macros, finders = {}, {}

    def finder_of(name):
        if name not in finders:
            path = pathlib.Path(name).resolve()
            below = str(path.relative_to(root)) if path.is_relative_to(root) else ""
            finders[name] = Finder(below, Source(path.read_bytes()), macros.get(name, ())) if wanted(below) else None
        return finders[name]

    def visit(cursor):
        for child in cursor.get_children():
            finder = finder_of(child.location.file.name) if child.location.file else None
            if finder and child.kind in SCOPES:
                visit(child)
            elif finder and child.kind in FUNCTIONS and child.is_definition():
                finder.function(child)

    for cursor in unit.cursor.get_children():
        if cursor.kind == Kind.MACRO_INSTANTIATION and cursor.location.file:
            macros.setdefault(cursor.location.file.name, set()).add(span_of(cursor))
    visit(unit.cursor)
    return [it for finder in finders.values() if finder for it in finder.found.values()]
