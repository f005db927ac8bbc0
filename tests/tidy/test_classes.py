#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Shows that classes.py counts what it is there to count, and nothing else."""

import contextlib
import io
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE))
sys.dont_write_bytecode = True

import classes  # noqa: E402  (the path must be set first)


def members(*lines):
    """How many member functions a class with these lines has."""
    found = classes.classes_of("\n".join(("class Pump final : public Thing<int> {", *lines, "};")))
    return dict(found)["Pump"]


def functions(number):
    return "".join(f"  void turn_{place}(int times);\n" for place in range(number))


@contextlib.contextmanager
def tree(files):
    with tempfile.TemporaryDirectory() as folder:
        for path, text in files.items():
            file = pathlib.Path(folder, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        yield pathlib.Path(folder)


def findings(files):
    with tree(files) as root:
        return classes.check_tree(root)[0]


class Members(unittest.TestCase):
    def test_each_of_these_is_a_member_function(self):
        for line in (
            "void run();",
            "public: void run();",
            "void run() {}",
            "void run() { if (a) { b(); } }",
            "[[nodiscard]] virtual bool is_on() const noexcept = 0;",
            "bool is_on() const noexcept(true) override { return on_; }",
            "Pump();",
            "Pump() = default;",
            "explicit(true) Pump(int a, std::function<void(int)> b = {}) : Thing<int>{a}, b_(std::move(b)) {}",
            "Pump(int a)\n    : Thing(a),\n      b_{{a}, {b(a)}} {\n  start();\n}",
            "~Pump();",
            "static Pump make(int a = std::max(1, 2));",
            "template <typename Kind, std::size_t kSize = (1 < 2)>\nvoid take(Kind&& kind);",
            "template <typename Kind> requires(std::is_same_v<Kind, int>) void take(Kind kind) { kind(); }",
            "auto begin() const -> std::vector<int>::const_iterator { return all_.begin(); }",
            "std::map<int, std::pair<int, int>> all();",
            "decltype(auto) all() const;",
            "bool operator()(int a) const { return a < 1; }",
            "auto operator<=>(const Pump&) const = default;",
            "Pump& operator=(Pump&& other);",
            "explicit operator bool() const { return true; }",
            "const int& operator[](int a) const;",
            'void say(const char* text = "a; b(); {");',
            "void say(char a = ';', int b = 1'000'000);",
        ):
            with self.subTest(line=line):
                self.assertEqual(members(line), 1)
                self.assertEqual(members("int a_ = 0;", line, "int b_{};", line, "void last();"), 3)

    def test_none_of_these_is(self):
        for line in (
            "int a_;",
            "int a_ = make(1);",
            "int a_{make(1)};",
            "std::vector<int> a_{1, 2};",
            "alignas(64) int a_;",
            "static constexpr auto kSize = sizeof(int) * (2 + 1);",
            "std::function<void(int)> then_ = [](int a) { go(a); };",
            "std::array<int, (1 + 2)> a_;",
            "using Next = std::function<bool(int)>;",
            "typedef void (*Callback)(int);",
            "enum class State : std::uint8_t { on, off };",
            "static_assert(sizeof(int) == 4);",
            "friend struct Reader;",
            "friend bool operator==(const Pump&, const Pump&) = default;",
            "friend void swap(Pump& a, Pump& b) { a.swap(b); }",
            "Pump(const Pump&) = delete;",
            "Pump& operator=(const Pump&) = delete;  // it is one of a kind",
            "// void run();",
            "/* void run(); */",
            "#define RUN void run();",
            "struct Part { void run(); int a() const { return 1; } };",
            "struct Part { void run(); } part_;",
            "class Part;",
            'const char* text_ = R"(void run(); {)";',
        ):
            with self.subTest(line=line):
                self.assertEqual(members(line), 0)
                self.assertEqual(members("void first();", line, "void last();"), 2)

    def test_a_class_within_another_counts_for_itself(self):
        text = "namespace a::b {\nstruct Outer {\n  struct Inner {\n    void a();\n    void b() {}\n  };\n  void c();\n};\n}\n"
        self.assertEqual(classes.classes_of(text), [("Inner", 2), ("Outer", 1)])

    def test_what_is_no_definition_of_a_class_is_none(self):
        for line in ("class Pump;", "enum class Pump { a };", "enum struct Pump : int { a };", "void run(struct Pump* it) { it(); }",
                     "template <class Pump> void run() { Pump::go(); }", "struct Pump* run() { return go(); }"):
            with self.subTest(line=line):
                self.assertEqual(classes.classes_of(line), [])

    def test_other_forms_of_a_class(self):
        for line, name in (("template <>\nstruct Pump<int> { void a(); };", "Pump<int>"),
                           ("class Pump : public A, private B<int> { void a(); };", "Pump"),
                           ("union Pump { void a(); };", "Pump"),
                           ("int b() { return 1; }\nstruct { void a(); } pump;", "without a name")):
            with self.subTest(line=line):
                self.assertEqual(classes.classes_of(line), [(name, 1)])


class Trees(unittest.TestCase):
    def test_a_class_may_have_so_many_and_no_more(self):
        for number, found in (
            (25, []),
            (26, ["src/bus/pump.hpp: class Pump has 26 member functions, more than 25"]),
        ):
            with self.subTest(number=number):
                self.assertEqual(findings({"src/bus/pump.hpp": f"class Pump {{\n{functions(number)}}};\n"}), found)

    def test_other_modules_may_have_what_they_like(self):
        self.assertEqual(findings({"src/io/pump.hpp": f"class Pump {{\n{functions(40)}}};\n"}), [])

    def test_the_bodies_of_a_class_are_in_two_sources_at_most(self):
        files = {"src/bus/pump.hpp": "class Pump {\n  Pump();\n  void a();\n  void b() { Pump::a(); }\n};\n"}
        for number, body in enumerate(("Pump::Pump() {}", "void Pump::a() {}", "// void Pump::b() {}\nvoid c() { Pump::d(); }")):
            files[f"src/bus/pump_{number}.cpp"] = body + "\n"
        self.assertEqual(findings(files), [])
        files["src/bus/deep/pump_3.cpp"] = "std::vector<int>::iterator Pump::b() {}\n"
        self.assertEqual(
            findings(files),
            ["src/bus: class Pump has bodies in 3 sources, more than 2: src/bus/deep/pump_3.cpp, src/bus/pump_0.cpp, "
             "src/bus/pump_1.cpp"],
        )

    def test_the_command_fails_on_a_finding_and_on_an_empty_tree(self):
        for files, status in (({}, 1), ({"src/bus/pump.hpp": "class Pump {};\n"}, 0),
                              ({"src/bus/pump.hpp": f"class Pump {{\n{functions(26)}}};\n"}, 1)):
            with tree(files) as root, mock.patch.object(sys, "argv", ["classes.py", str(root)]):
                with self.subTest(files=len(files)), contextlib.redirect_stdout(io.StringIO()):
                    self.assertEqual(classes.main(), status)


if __name__ == "__main__":
    unittest.main(verbosity=2)
