// SPDX-License-Identifier: Apache-2.0
// Typed reading of TOML. A TomlDocument owns the text of a file, or of several that are read as
// one, its values and its diagnostics; a TomlTable is a light view of one table in it. Every key
// that is read becomes known. finish() reports the keys that were never read, so read every key of
// a table before that. Nothing here throws: an error becomes a diagnostic, and the caller gets
// nothing.
//
//   auto document = TomlDocument::parse({read_text_file("conf/x.toml")});
//   for (TomlTable bus : document.root().tables("bus")) {
//     bus.require("name");
//     assign(settings.name, bus.string("name"));
//     assign(settings.response_timeout, bus.duration("response_timeout", {1ms, 1h}));
//   }
//   std::vector<Diagnostic> diagnostics = document.finish();   // if has_errors(), do not use the
//   settings
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fmt/core.h>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/diagnostic.hpp"
#include "config/text_file.hpp"
#include "config/toml/toml_value.hpp"

namespace mbgate::config {

/// Both ends belong to the range.
struct IntegerRange {
  std::int64_t min;
  std::int64_t max;
};

/// With `zero_is_off`, a duration of 0 is allowed in addition to the range, and turns something
/// off.
struct DurationRange {
  std::chrono::nanoseconds min;
  std::chrono::nanoseconds max;
  bool zero_is_off = false;
  std::chrono::nanoseconds step{0};  ///< 1s or 1ms: a whole number of these
};

/// "an integer from 1 to 16", "a duration from 10ms to 1h".
std::string range_text(const IntegerRange& range);
std::string range_text(const DurationRange& range);

/// One word of a closed set and what it stands for.
template <typename Value>
struct Word {
  std::string_view text;
  Value value;
};

/// The word for a value; empty if it has none.
template <typename Value, std::size_t kSize>
constexpr std::string_view word_for(const std::array<Word<Value>, kSize>& words, Value value) {
  const auto* const word = std::ranges::find(words, value, &Word<Value>::value);
  return word == words.end() ? std::string_view() : word->text;
}

/// What the word stands for; nothing if it is none of these.
template <typename Value, std::size_t kSize>
constexpr std::optional<Value> value_of(const std::array<Word<Value>, kSize>& words,
                                        std::string_view text) {
  const auto* const word = std::ranges::find(words, text, &Word<Value>::text);
  return word == words.end() ? std::nullopt : std::optional(word->value);
}

class TomlDocument;

/// Valid as long as its document. Each getter returns nothing if the key is absent or its value is
/// wrong; a wrong value is reported at its position.
class TomlTable {
 public:
  /// Where the table begins: its header, or the brace of an inline table.
  [[nodiscard]] Position position() const;
  /// "[[bus]]", "[gateway]"; empty for the root.
  [[nodiscard]] const std::string& title() const;

  /// Is the key there? Makes it known.
  bool has(std::string_view key);
  /// Reports the key as missing if it is not there.
  bool require(std::string_view key);
  /// The same of each of the keys.
  void require_all(std::initializer_list<const char*> keys);
  /// Reports those of the keys that are there.
  void reject(std::initializer_list<const char*> keys, std::string_view message);
  /// Makes the keys known, present or not.
  void accept(std::initializer_list<const char*> keys);
  /// The value of a key that may have several types; nullptr if absent.
  const TomlValue* value(std::string_view key);
  /// Where the value of a key is; the table's position if the key is absent.
  [[nodiscard]] Position value_position(std::string_view key) const;
  /// "conf/x.toml:12:8": the same, to name it in a message at another place.
  [[nodiscard]] std::string place_of(std::string_view key) const;

  std::optional<std::string> string(std::string_view key);
  std::optional<bool> boolean(std::string_view key);
  std::optional<std::int64_t> integer(std::string_view key, IntegerRange range);
  /// A string with its unit: "250us", "1.75ms", "2s", "10m", "1h"; exact.
  std::optional<std::chrono::nanoseconds> duration(std::string_view key, DurationRange range);
  /// The strings of a list, each with its position.
  std::optional<std::vector<TomlText>> strings(std::string_view key);
  /// The elements of a list of mixed types; nullptr if absent.
  const std::vector<TomlValue>* list(std::string_view key);
  /// One of the words.
  template <typename Value>
  std::optional<Value> word(std::string_view key, std::span<const Word<Value>> words) {
    std::vector<std::string_view> texts;
    for (const auto& word : words) {
      texts.push_back(word.text);
    }
    const auto index = word_index(key, texts);
    return index ? std::optional<Value>(words[*index].value) : std::nullopt;
  }

  /// `[key]`; absent: nothing.
  std::optional<TomlTable> table(std::string_view key);
  /// `[[key]]`, in the order of the files and of their texts; absent: none.
  std::vector<TomlTable> tables(std::string_view key);

  /// Reports an error at the value of `key` (at the table if it is absent); the message begins with
  /// the key. With more arguments it is a format of libfmt, here as below.
  void error(std::string_view key, std::string_view message);
  template <class First, class... Rest>
  void error(std::string_view key, fmt::format_string<First, Rest...> message, First&& first,
             Rest&&... rest) {
    error(key, fmt::format(message, std::forward<First>(first), std::forward<Rest>(rest)...));
  }
  void warning(std::string_view key, std::string_view message);
  template <class First, class... Rest>
  void warning(std::string_view key, fmt::format_string<First, Rest...> message, First&& first,
               Rest&&... rest) {
    warning(key, fmt::format(message, std::forward<First>(first), std::forward<Rest>(rest)...));
  }
  /// Reports at `found`: "KEY: expected EXPECTED, found ...".
  void report_expected(std::string_view key, const TomlValue& found, std::string_view expected);
  template <class First, class... Rest>
  void report_expected(std::string_view key, const TomlValue& found,
                       fmt::format_string<First, Rest...> expected, First&& first, Rest&&... rest) {
    report_expected(key, found,
                    std::string_view(fmt::format(expected, std::forward<First>(first),
                                                 std::forward<Rest>(rest)...)));
  }
  [[nodiscard]] TomlDocument& document() const { return *document_; }

 private:
  friend class TomlDocument;
  TomlTable(TomlDocument& document, TomlTableValue& node) : document_(&document), node_(&node) {}
  std::optional<std::size_t> word_index(std::string_view key,
                                        const std::vector<std::string_view>& words);

  TomlDocument* document_;
  TomlTableValue* node_;
};

/// One file, or several that are read as one. Neither copied nor moved while views of it exist.
class TomlDocument {
 public:
  /// Reads at least one file, each of at most 1 MiB. A file that could not be read, or is not TOML,
  /// gives an empty document with a diagnostic. Lists of tables, `[[key]]`, are put together in the
  /// order of the files; the keys of a table `[key]` may stand in several. What is said twice is an
  /// error.
  static TomlDocument parse(const std::vector<TextFile>& files);

  /// The name of the file that a place is in.
  [[nodiscard]] const std::string& name(Position position = {}) const {
    return files_[position.file].name;
  }
  /// False if one of the texts could not be read or is not TOML; then there are no values.
  [[nodiscard]] bool parsed() const { return parsed_; }
  [[nodiscard]] TomlTable root();
  /// Was an error reported so far?
  [[nodiscard]] bool failed() const { return has_errors(diagnostics_); }

  void error(Position position, std::string message);
  template <class First, class... Rest>
  void error(Position position, fmt::format_string<First, Rest...> message, First&& first,
             Rest&&... rest) {
    error(position, fmt::format(message, std::forward<First>(first), std::forward<Rest>(rest)...));
  }
  void warning(Position position, std::string message);
  template <class First, class... Rest>
  void warning(Position position, fmt::format_string<First, Rest...> message, First&& first,
               Rest&&... rest) {
    warning(position,
            fmt::format(message, std::forward<First>(first), std::forward<Rest>(rest)...));
  }

  /// Reports the keys that were never read and returns all diagnostics, in the order of the files
  /// and of their texts.
  std::vector<Diagnostic> finish();

 private:
  struct File {
    std::string name;
    std::vector<std::string> lines;
  };

  TomlDocument() = default;
  /// The values of the file of this number; nothing if it is wrong, which is reported.
  std::optional<TomlTableValue> read_file(std::uint32_t number, std::string_view text);
  /// Adds what a later file says.
  void join(TomlTableValue& table, TomlTableValue added);
  void join(TomlEntry& entry, TomlEntry added);
  void report(Severity severity, Position position, std::string message);
  void report_syntax(Position position, std::string_view description);
  void report_unknown_keys(const TomlTableValue& table);

  std::vector<File> files_;
  std::unique_ptr<TomlTableValue> root_ = std::make_unique<TomlTableValue>();
  std::vector<Diagnostic> diagnostics_;
  bool parsed_ = false;
};

/// "conf/x.toml:12:8", to name a second place in a message.
std::string place(const TomlDocument& document, Position position);

/// Assigns what was read; if nothing was, the target keeps its default. The ranges given to the
/// getters ensure that a number fits its target.
template <typename Target, typename Source>
void assign(Target& target, std::optional<Source> source) {
  if (source) {
    target = static_cast<Target>(*std::move(source));
  }
}

template <typename Value>
void assign(std::optional<Value>& target, std::optional<Value> source) {
  if (source) {
    target = std::move(source);
  }
}

}  // namespace mbgate::config
