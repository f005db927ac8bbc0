// SPDX-License-Identifier: Apache-2.0
#include "config/toml/toml_reader.hpp"

#include <gtest/gtest.h>

#include <array>

namespace mbgate::config {
namespace {

using namespace std::chrono_literals;

enum class Colour : std::uint8_t { red, green };
constexpr std::array kColours = {Word{"red", Colour::red}, Word{"green", Colour::green}};

TomlDocument parse(std::string text) {
  return TomlDocument::parse({TextFile{"x", std::move(text)}});
}

TEST(TomlReader, ReadsEveryType) {
  auto document = parse(R"(
text = "a"
truth = true
integer = -3
wait = "1.75ms"
word = "green"
words = ["a", "b"]
[inner]
key = 1
[[rows]]
key = 2
[[rows]]
key = 3
)");
  auto root = document.root();
  EXPECT_EQ(root.string("text"), "a");
  EXPECT_EQ(root.boolean("truth"), true);
  EXPECT_EQ(root.integer("integer", {-3, 0}), -3);
  EXPECT_EQ(root.duration("wait", {1ms, 2ms}), 1750us);
  EXPECT_EQ(root.word<Colour>("word", kColours), Colour::green);
  const auto words = root.strings("words");
  ASSERT_TRUE(words && words->size() == 2);
  EXPECT_EQ((*words)[1].text, "b");
  EXPECT_EQ((*words)[1].position, (Position{7, 15}));
  auto inner = root.table("inner");
  ASSERT_TRUE(inner);
  EXPECT_EQ(inner->title(), "[inner]");
  EXPECT_EQ(inner->integer("key", {1, 1}), 1);
  auto rows = root.tables("rows");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].integer("key", {0, 9}), 2);
  EXPECT_EQ(rows[1].integer("key", {0, 9}), 3);
  EXPECT_EQ(rows[1].title(), "[[rows]]");
  EXPECT_EQ(rows[1].position(), (Position{12, 1}));
  EXPECT_EQ(render(document.finish()), "");
}

TEST(TomlReader, GivesNothingForAbsentKeys) {
  auto document = parse("");
  ASSERT_TRUE(document.parsed());
  auto root = document.root();
  EXPECT_FALSE(root.string("a") || root.boolean("a") || root.integer("a", {0, 1}) ||
               root.duration("a", {0s, 1s}) || root.strings("a") || root.table("a") ||
               root.word<Colour>("a", kColours));
  EXPECT_TRUE(root.tables("a").empty());
  EXPECT_EQ(render(document.finish()), "");
}

TEST(TomlReader, SaysWhatWasExpectedOfEveryType) {
  auto document = parse("a = [1]\nb = {}\nc = 1979-05-27\nd = 1.5\n");
  auto root = document.root();
  EXPECT_FALSE(root.string("a") || root.boolean("b") || root.integer("d", {5, 6}) ||
               root.integer("c", {0, 1}) || root.strings("b") || root.table("a") ||
               root.word<Colour>("d", kColours));
  EXPECT_TRUE(root.tables("b").empty());
  EXPECT_TRUE(root.tables("a").empty());
  EXPECT_EQ(render(document.finish()),
            "x:1:5: error: a: expected a string, found a list\na = [1]\n    ^\n"
            "x:1:5: error: a: expected the table [a], found a list\na = [1]\n    ^\n"
            "x:1:6: error: a: expected tables headed [[a]], found 1\na = [1]\n     ^\n"
            "x:2:5: error: b: expected true or false, found a table\nb = {}\n    ^\n"
            "x:2:5: error: b: expected a list in square brackets, found a table\nb = {}\n    ^\n"
            "x:2:5: error: b: expected tables headed [[b]], found a table\nb = {}\n    ^\n"
            "x:3:5: error: c: expected an integer from 0 to 1, found a date or time\n"
            "c = 1979-05-27\n    ^\n"
            "x:4:5: error: d: expected an integer from 5 to 6, found 1.5\nd = 1.5\n    ^\n"
            "x:4:5: error: d: expected \"red\" or \"green\", found 1.5\nd = 1.5\n    ^\n");
}

TEST(TomlReader, AllowsZeroOnlyWhereItTurnsSomethingOff) {
  auto document = parse("a = \"0s\"\nb = \"0ms\"\n");
  auto root = document.root();
  EXPECT_EQ(root.duration("a", {1s, 1h, true}), 0s);
  EXPECT_FALSE(root.duration("b", {1s, 1h}));
  EXPECT_EQ(
      render(document.finish()),
      "x:2:5: error: b: expected a duration from 1s to 1h, found \"0ms\"\nb = \"0ms\"\n    ^\n");
}

TEST(TomlReader, ReportsKeysNobodyAskedForAtTheKey) {
  auto document = parse("[[bus]]\nname = \"a\"\n  baut = 9600\nlist = [{z = 1}]\n");
  for (auto bus : document.root().tables("bus")) {
    bus.string("name");
    bus.integer("baud", {1, 9});
    for (auto inner : bus.tables("list")) {
      inner.has("zz");
    }
  }
  EXPECT_EQ(render(document.finish()),
            "x:3:3: error: unknown key 'baut' in [[bus]]; did you mean 'baud'?\n"
            "  baut = 9600\n  ^\n"
            "x:4:10: error: unknown key 'z' in [[bus.list]]\n"
            "list = [{z = 1}]\n         ^\n");
}

TEST(TomlReader, ReportsWhatIsMissingAtTheTable) {
  auto document = parse("\n[[bus]]\n");
  EXPECT_FALSE(document.root().tables("bus")[0].require("name"));
  EXPECT_FALSE(document.root().require("log"));
  const auto diagnostics = document.finish();
  EXPECT_EQ(render(diagnostics),
            "x:1:1: error: the key 'log' is missing\n\n^\n"
            "x:2:1: error: [[bus]]: the key 'name' is missing\n[[bus]]\n^\n");
}

TEST(TomlReader, SkipsAByteOrderMarkAndCarriageReturns) {
  auto document = parse("\xEF\xBB\xBFz = 1\r\ny = 2\r\n");
  document.root().has("none");
  EXPECT_EQ(render(document.finish()),
            "x:1:1: error: unknown key 'z'\nz = 1\n^\nx:2:1: error: unknown key 'y'\ny = 2\n^\n");
}

TEST(TomlReader, SortsByPositionAndKeepsWarningsApart) {
  auto document = parse("a = 1\nb = 2\n");
  auto root = document.root();
  root.error("b", "wrong");
  root.warning("a", "odd");
  EXPECT_TRUE(document.failed());
  EXPECT_EQ(render(document.finish()),
            "x:1:5: warning: a: odd\na = 1\n    ^\nx:2:5: error: b: wrong\nb = 2\n    ^\n");
}

TEST(TomlReader, ShowsLongAndStrangeStringsShortAndPlain) {
  auto document = parse(R"(a = "\n\t\u001B)" + std::string(100, 'y') + "\"\n");
  document.root().integer("a", {0, 1});
  const auto diagnostics = document.finish();
  ASSERT_EQ(diagnostics.size(), 1U);
  EXPECT_EQ(diagnostics[0].message,
            "a: expected an integer from 0 to 1, found \"\\n\\t?" + std::string(55, 'y') + "...\"");
}

TEST(TomlReader, RefusesLinesThatAreTooLong) {
  auto document = parse("a = 1\nb" + std::string(5000, '.') + "b = 1\n");
  EXPECT_FALSE(document.parsed());
  EXPECT_EQ(render(document.finish()),
            "x:2:1: error: the line is longer than 4096 bytes\nb" + std::string(79, '.') + "\n^\n");
}

// Lists go on over lines, and what is in them may have keys as long as a line.
TEST(TomlReader, RefusesWhatIsNestedTooDeep) {
  std::string text = "x = ";
  std::string dotted = "[\n{ a";
  for (int times = 0; times < 1900; ++times) {
    dotted += ".a";
  }
  for (int times = 0; times < 8; ++times) {
    text += dotted + " = ";
  }
  auto document = parse(text + "1");
  EXPECT_FALSE(document.parsed());
  EXPECT_EQ(render(document.finish()).substr(0, 50),
            "x:5:3807: error: syntax: a value is nested too dee");
}

TEST(TomlReader, RefusesFilesThatAreTooLarge) {
  auto document = parse(std::string(1024 * 1024 + 1, '\n'));
  EXPECT_FALSE(document.parsed());
  EXPECT_EQ(render(document.finish()),
            "x: error: is larger than 1 MiB: expected a configuration\n");
}

/// The library takes such keys for impossible in one place and for an error in the next.
TEST(TomlReader, ReportsKeysThatBeginWithNoLetterOfKeys) {
  EXPECT_EQ(render(parse("[.]\n").finish()),
            "x:1:2: error: syntax: key: expected bare key starting character or string delimiter, "
            "saw '.'\n[.]\n ^\n");
  EXPECT_EQ(render(parse("a = 1\n[\xC3\xA4]\n").finish()),
            "x:2:2: error: syntax: key: expected bare key starting character or string delimiter, "
            "saw '\xC3\xA4'\n[\xC3\xA4]\n ^\n");
  for (const auto* text : {"[[", "[=]", "[#]", "[[.a]]", "a.\xC3\xA4 = 1", "a\xC3\xA4 = 1",
                           "\xC3\xA4 = 1", "a = \xC3\xA4", "a = 1 \xC3\xA4"}) {
    const auto diagnostics = parse(text).finish();
    ASSERT_EQ(diagnostics.size(), 1U) << text;
    EXPECT_EQ(diagnostics[0].message.substr(0, 8), "syntax: ");
  }
}

TEST(TomlReader, SurvivesTheDeepestNestingALineCanHold) {
  std::string deep = "a";
  while (deep.size() < 4080) {
    deep += ".a";
  }
  auto document = parse(deep + " = 1\n");
  EXPECT_TRUE(document.parsed());
  EXPECT_TRUE(document.root().has("a"));
}

TEST(TomlReader, SaysWhyAFileCannotBeRead) {
  const auto absent = std::string(MBGATE_SOURCE_DIR) + "/no-such-file.toml";
  EXPECT_EQ(render(TomlDocument::parse({read_text_file(absent)}).finish()),
            absent + ": error: cannot be read: No such file or directory\n");
  EXPECT_EQ(render(TomlDocument::parse({read_text_file(MBGATE_SOURCE_DIR)}).finish()),
            std::string(MBGATE_SOURCE_DIR) + ": error: cannot be read: Is a directory\n");
}

}  // namespace
}  // namespace mbgate::config
