// SPDX-License-Identifier: Apache-2.0
// The printed frames of the drive manuals as test vectors: see README.md beside this file.
// A file that cannot be read or does not have its shape throws std::runtime_error with file and
// line, so a damaged vector fails the test that asked for it.
#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace mbgate::manuals {

using ByteList = std::vector<std::uint8_t>;

enum class Direction : std::uint8_t { request, response };

/// One frame: address, PDU and CRC (load_rtu) or address and PDU (load_without_crc).
struct Frame {
  std::string manual;
  unsigned line = 0;
  Direction direction = Direction::request;
  std::optional<unsigned> answers;  ///< the line of the request that this response belongs to
  ByteList bytes;
  [[nodiscard]] std::string where() const { return manual + ':' + std::to_string(line); }
};

/// The same request or response as an RTU frame and as a TCP ADU.
struct Pair {
  std::string manual;
  unsigned line = 0;
  Direction direction = Direction::request;
  std::optional<unsigned> answers;
  ByteList rtu;
  ByteList tcp;
  [[nodiscard]] std::string where() const { return manual + ':' + std::to_string(line); }
};

/// A request and, where the manual prints it, its response.
struct Transaction {
  Pair request;
  std::optional<Pair> response;
};

enum class MisprintKind : std::uint8_t { rtu, tcp };

struct Misprint {
  std::string manual;
  unsigned line = 0;
  MisprintKind kind = MisprintKind::rtu;
  std::string fault;
  ByteList printed;
  ByteList right;
  [[nodiscard]] std::string where() const { return manual + ':' + std::to_string(line); }
};

namespace detail {

using Columns = std::vector<std::string>;

[[noreturn]] inline void fail(const std::string& place, const std::string& what) {
  throw std::runtime_error(place + ": " + what);
}

inline Columns split(const std::string& text, char divider) {
  Columns columns;
  std::istringstream stream(text);
  for (std::string column; std::getline(stream, column, divider);) {
    columns.push_back(column);
  }
  return columns;
}

inline ByteList parse_bytes(const std::string& text, const std::string& place) {
  ByteList bytes;
  for (const std::string& digits : split(text, ' ')) {
    if (digits.size() != 2 || digits.find_first_not_of("0123456789ABCDEF") != std::string::npos) {
      fail(place, "'" + digits + "' is no byte");
    }
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(digits, nullptr, 16)));
  }
  if (bytes.empty()) {
    fail(place, "no bytes");
  }
  return bytes;
}

inline unsigned parse_number(const std::string& text, const std::string& place) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string::npos) {
    fail(place, "'" + text + "' is no line number");
  }
  return static_cast<unsigned>(std::stoul(text));
}

inline std::optional<unsigned> parse_answers(const std::string& text, const std::string& place) {
  return text == "-" ? std::nullopt : std::optional(parse_number(text, place));
}

inline Direction parse_direction(const std::string& text, const std::string& place) {
  if (text != "request" && text != "response") {
    fail(place, "'" + text + "' is no direction");
  }
  return text == "request" ? Direction::request : Direction::response;
}

/// Calls `use(columns, place)` for every line below the heading, which must be `heading`.
template <typename Use>
void for_each_row(const std::string& name, const std::string& heading, Use use) {
  const std::string path = std::string(MBGATE_SOURCE_DIR "/tests/manuals/") + name;
  std::ifstream file(path);
  std::string text;
  if (!std::getline(file, text) || text != heading) {
    fail(path + ":1", "expected the heading '" + heading + "'");
  }
  const std::size_t width = split(heading, '\t').size();
  for (unsigned number = 2; std::getline(file, text); ++number) {
    const std::string place = path + ':' + std::to_string(number);
    const Columns columns = split(text, '\t');
    if (columns.size() != width) {
      fail(place, std::to_string(columns.size()) + " columns, expected " + std::to_string(width));
    }
    use(columns, place);
  }
}

inline std::vector<Frame> load_frames(const std::string& name) {
  std::vector<Frame> frames;
  for_each_row(name, "manual\tline\tdirection\tanswers\tframe",
               [&](const Columns& columns, const std::string& place) {
                 const bool both = columns[2] == "both";
                 Frame frame{columns[0], parse_number(columns[1], place),
                             parse_direction(both ? "request" : columns[2], place),
                             parse_answers(columns[3], place), parse_bytes(columns[4], place)};
                 frames.push_back(frame);
                 if (both) {
                   frame.direction = Direction::response;
                   frame.answers = frame.line;
                   frames.push_back(frame);
                 }
               });
  return frames;
}

}  // namespace detail

/// Every printed RTU frame with the right CRC. One that is printed for request and echo comes as
/// both.
inline std::vector<Frame> load_rtu() { return detail::load_frames("rtu.tsv"); }

/// Frames that are printed without their CRC: address and PDU.
inline std::vector<Frame> load_without_crc() { return detail::load_frames("without_crc.tsv"); }

/// Every example that is printed as an RTU frame and as a TCP ADU, misprints corrected.
inline std::vector<Pair> load_pairs() {
  std::vector<Pair> pairs;
  detail::for_each_row("pairs.tsv", "manual\tline\tdirection\tanswers\trtu\ttcp",
                       [&](const detail::Columns& columns, const std::string& place) {
                         pairs.push_back({columns[0], detail::parse_number(columns[1], place),
                                          detail::parse_direction(columns[2], place),
                                          detail::parse_answers(columns[3], place),
                                          detail::parse_bytes(columns[4], place),
                                          detail::parse_bytes(columns[5], place)});
                       });
  return pairs;
}

/// The pairs put together; a response belongs to the request that stands before it.
inline std::vector<Transaction> load_transactions() {
  std::vector<Transaction> transactions;
  for (const Pair& pair : load_pairs()) {
    if (pair.direction == Direction::request) {
      transactions.push_back({pair, std::nullopt});
    } else if (transactions.empty() || transactions.back().request.line != pair.answers) {
      detail::fail(pair.where(), "the request before it is another one's");
    } else {
      transactions.back().response = pair;
    }
  }
  return transactions;
}

/// What is printed wrong, with what is right.
inline std::vector<Misprint> load_misprints() {
  std::vector<Misprint> misprints;
  detail::for_each_row(
      "misprints.tsv", "manual\tline\tkind\tdirection\tfault\tprinted\tright",
      [&](const detail::Columns& columns, const std::string& place) {
        if (columns[2] != "rtu" && columns[2] != "tcp") {
          detail::fail(place, "'" + columns[2] + "' is no kind");
        }
        misprints.push_back({columns[0], detail::parse_number(columns[1], place),
                             columns[2] == "rtu" ? MisprintKind::rtu : MisprintKind::tcp,
                             columns[4], detail::parse_bytes(columns[5], place),
                             detail::parse_bytes(columns[6], place)});
      });
  return misprints;
}

}  // namespace mbgate::manuals
