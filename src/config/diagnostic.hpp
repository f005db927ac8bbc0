// SPDX-License-Identifier: Apache-2.0
// An error or warning about the files of a configuration, with its place. It is printed as
// compilers do: with the line itself and a caret below the place.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace mbgate::config {

/// A place in one of the texts that are read together; lines and columns count from 1, columns in
/// characters (code points). Line 0 means the file as a whole. Places are in the order of the
/// files, then of the text.
struct Position {
  std::uint32_t line = 0;
  std::uint32_t column = 0;
  std::uint32_t file = 0;  ///< the files count from 0, in the order in which they are read
  friend auto operator<=>(const Position& a, const Position& b) {
    return std::tie(a.file, a.line, a.column) <=> std::tie(b.file, b.line, b.column);
  }
  friend bool operator==(const Position&, const Position&) = default;
};

/// A warning is shown and changes nothing; with one error the configuration is refused.
enum class Severity : std::uint8_t { error, warning };

struct Diagnostic {
  Severity severity = Severity::error;
  std::string file;
  Position position;
  std::string message;      ///< what was found and what was expected, without place and newline
  std::string source_line;  ///< the line of the file, without its newline
};

/// One diagnostic, each of its lines ended by a newline:
///   conf/x.toml:12:8: error: baud: expected an integer from 1 to 4294967295, found "fast"
///   baud = "fast"
///          ^
std::string render(const Diagnostic& diagnostic);

/// The first line of it, without its newline.
std::string headline(const Diagnostic& diagnostic);

/// All of them, in the given order.
std::string render(const std::vector<Diagnostic>& diagnostics);

/// Is one of them an error?
bool has_errors(const std::vector<Diagnostic>& diagnostics);

/// The places of keys that deny requests, such as "mbgate.toml:12", by the key ("allow" and
/// "read_only" of listeners, "access", "functions" and "windows" of routes, "writer" of devices)
/// and the index of its entry. Where a route does not have the key, it is the place of the route.
/// The gateway does not need them; `--check --who` names them.
using KeyPlaces = std::map<std::pair<std::string_view, std::size_t>, std::string>;

}  // namespace mbgate::config
