#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What each mutator makes of a small piece of source, and that the switched text does that when it is switched on."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import mutate  # noqa: E402
import mutators  # noqa: E402
import run  # noqa: E402

BEGIN = "// SPDX-License-Identifier: Apache-2.0\n"


class Piece(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()

    def found(self, text, mutator=None):
        (self.root / "a.hpp").write_text(BEGIN + text, encoding="utf-8")
        self.source = mutators.Source((BEGIN + text).encode())
        places = mutators.places(f'#include "{self.root}/a.hpp"\n', self.root, lambda it: it == "a.hpp", ["-std=c++20"])
        return sorted(it for it in places if mutator in (None, it.mutator))

    def changes(self, text, mutator):
        return [(self.source.piece(it.start, it.end), self.source.plain(it)) for it in self.found(text, mutator)]


class AMutator(Piece):
    def test_drops_statements(self):
        text = "inline int f(int a) { ++a; int b = a; b = 3; if (a) { b += a; } return b; }\n"
        self.assertEqual(self.changes(text, "drop"), [("++a", ""), ("b = 3", ""), ("b += a", "")])

    def test_negates_conditions(self):
        text = ("inline bool f(int a, bool b) { if (a > 0) { return b; } while (b && a != 1) { --a; }\n"
                "  if (const int c = a + 1) { return c == a ? b : true; } return false; }\n")
        self.assertEqual(self.changes(text, "negate"), [
            ("a > 0", "!(a > 0)"), ("b", "!(b)"), ("b", "!(b)"), ("b && a != 1", "!(b && a != 1)"),
            ("a != 1", "!(a != 1)"), ("const int c = a + 1", "const int c = a + 1; !c"), ("c == a", "!(c == a)"),
            ("c == a ? b : true", "!(c == a ? b : true)"), ("false", "!(false)")])

    def test_shifts_integers(self):
        text = "constexpr int kMost = 9;\ninline unsigned f(int a) { return a > kMost ? 0xFFU : 0U; }\n"
        self.assertEqual(self.changes(text, "shift"), [
            ("kMost", "(kMost - 1)"), ("kMost", "(kMost + 1)"), ("0xFFU", "0xFEU"), ("0xFFU", "0x100U"), ("0U", "1U")])

    def test_exchanges_arguments_of_one_type(self):
        text = ("struct S { int a; int b; };\nint g(int a, long b, S* c, S* d);\n"
                "inline int f(int a, S s) { return g(a, s.b, nullptr, &s) + g(a, a, &s, &s); }\n")
        self.assertEqual(self.changes(text, "exchange"), [
            ("g(a, s.b, nullptr, &s)", "g(s.b, a, nullptr, &s)"), ("g(a, s.b, nullptr, &s)", "g(a, s.b, &s, nullptr)")])

    def test_leaves_functions_at_once(self):
        text = ("void g();\ninline void e() {}\ninline void f() { g(); }\n"
                "struct S { S() { g(); } bool b() { return true; } };\n")
        self.assertEqual([it for _, it in self.changes(text, "return")], ["{ return; ", "{ return; ", "{ return {}; "])

    def test_leaves_alone_what_cannot_be_switched(self):
        self.assertEqual(self.found(
            "#define CHECK(it) ((it) ? void() : throw 1)\n"
            "template <int I> int g() { static_assert(I > 1 && I < 9); return I; }\n"
            "inline int f(int a) { constexpr int b = 5; int c[7]; switch (a) { case 4: return g<3>() + c[a]; }\n"
            "  if constexpr (b == 5) { CHECK(a == 2 && a < 4); } return b; }\n", "shift"), [])

    def test_leaves_alone_words_for_people(self):
        text = '#include <string>\ninline std::string f(bool a) { return a ? "yes" : "no"; }\n'
        self.assertEqual(self.found(text), [])


class ASwitchedText(Piece):
    TEXT = ("struct Pair { int a, b; };\n"
            "constexpr Pair pair(int a, int b) { return {a, b}; }\n"
            "inline int f(int a, int b) {\n  int c = 10;\n"
            "  if (a < b && b > 0) {\n    c += pair(a - 1,\n              pair(b, a).a).b;\n  }\n  return c;\n}\n"
            "static_assert(pair(1, 2).b == 2);\n")

    def build(self, text, places):
        switched = self.source.switched(list(enumerate(places)))
        self.assertEqual(switched.count("\n"), self.source.text.count(b"\n"))
        header = mutators.HEADER.read_text(encoding="utf-8")
        for name, content in ((mutators.HEADER.name, header), ("a.hpp", switched), ("a.cpp", text)):
            (self.root / name).write_text(content, encoding="utf-8")
        subprocess.run(["g++", "-std=c++20", "-w", "-o", self.root / "a", self.root / "a.cpp"], check=True)

    def output(self, number=None, reached=None):
        given = {"MBGATE_MUTANT": number, "MBGATE_MUTANTS_REACHED": reached}
        surroundings = os.environ | {name: str(it) for name, it in given.items() if it is not None}
        return subprocess.run([self.root / "a"], env=surroundings, text=True, stdout=subprocess.PIPE, check=True).stdout

    def plain(self, place):
        text = self.source.piece(0, place.start) + self.source.plain(place) + self.source.piece(place.end, None)
        return text.replace("static_assert", "// ")

    def test_is_each_of_its_mutants_when_that_is_switched_on(self):
        places = self.found(self.TEXT)
        shown = 'std::printf("%d %d\\n", {0}f(1, 5), {0}f(5, 1));'
        self.build(f'#include "a.hpp"\n#include <cstdio>\nint main() {{ {shown.format("")} }}\n', places)
        unbroken, *broken = [self.output(number) for number in (None, *range(len(places)))]
        self.assertEqual(unbroken, "15 10\n")
        variants = "".join(f"namespace n{number} {{\n{self.plain(it)}}}\n" for number, it in enumerate(places))
        calls = "".join(shown.format(f"n{number}::") for number in range(len(places)))
        self.build(f"#include <cstdio>\n{variants}int main() {{ {calls} }}\n", places)
        self.assertEqual("".join(broken), self.output())
        self.assertGreater(len(set(broken)), 5)

    def test_notes_what_is_reached(self):
        places = self.found(self.TEXT, "drop") + self.found(self.TEXT, "return")
        self.build('#include "a.hpp"\nint main() { f(5, 1); }\n', places)
        self.output(reached=self.root / "reached")
        reached = {places[int(it)].mutator for it in (self.root / "reached").read_text(encoding="ascii").split()}
        self.assertEqual(reached, {"return"})


class AnOrder(unittest.TestCase):
    def test_is_the_same_for_a_seed_and_has_each_mutator_early(self):
        file = "src/modbus/frames.cpp"
        places = [mutators.Mutant(file, at, at + 1, name, None, "on") for name in mutators.MUTATORS for at in range(50)]
        self.assertEqual(mutate.in_order(places, 3), mutate.in_order(places[::-1], 3))
        self.assertNotEqual(mutate.in_order(places, 3), mutate.in_order(places, 4))
        self.assertEqual({it.mutator for it in mutate.in_order(places, 3)[:5]}, set(mutators.MUTATORS))


class TheCompilerRefuses(unittest.TestCase):
    FILE = "src/modbus/frames.cpp"

    def refused(self, text):
        build = mutate.Build(pathlib.Path("/build"), None)
        text_of_file = mutate.source_of(self.FILE).text
        at = {7: text_of_file.find(b"#include"), 8: text_of_file.find(b"namespace")}
        mutants = {it: mutators.Mutant(self.FILE, begin, begin + 1, "drop", None, "on") for it, begin in at.items()}
        lines = [mutate.lines_in(it)[0] for it in mutants.values()]
        return build.refused(text.format(*(f"/build/tree/{self.FILE}:{line}:3:" for line in lines)), mutants)

    def test_what_stands_where_it_finds_an_error(self):
        self.assertEqual(self.refused("{1} error: no match\n"), {8})
        self.assertEqual(self.refused("{0} warning: unused\n"), set())

    def test_what_led_it_there(self):
        self.assertEqual(self.refused("{0}   required from here\n/usr/include/a.h:5:1: error: no type\n"), {7})
        self.assertEqual(self.refused("{0}   required from here\n{1} error: no type\n"), {8})


class TheEqualOnes(unittest.TestCase):
    def test_are_known_by_their_lines(self):
        text = "# words\n\nsrc/bus/a.cpp shift\n  return a[1];\n  return a[2];\nBoth are\nthe same.\n"
        self.assertEqual(mutate.equivalents_in(text),
                         {("src/bus/a.cpp", "shift", "return a[1];", "return a[2];"): "Both are the same."})


if __name__ == "__main__":
    if mutators.cindex is None:
        print("libclang for Python is not installed (python3-clang-19)")
        sys.exit(run.SKIPPED)
    unittest.main()
