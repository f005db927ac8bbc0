// SPDX-License-Identifier: Apache-2.0
// A recording of the machine as text: a head with the configuration, then a line for each input,
// with its instant in nanoseconds, and one for each action, in the order in which they happened.
//
//   mbgate recording 1                    < open 0
//   version 0.1.0                         517 opened 0 virtual
//   config /etc/mbgate/mbgate.toml        < report bus line-a is open
//   profiles /srv/profiles                633 connected 0 0 192.0.2.1 0
//   | [[bus]]                             701 read 0 0 000100000006010300000001
//   | name = "line-a"                     < transmit 0 010300000001840A
//   500 start                             ...
//
// Other settings are recorded as in the head: the lines of their configuration, and "900 settings".
// Bytes are hexadecimal; a client is its number, a bus or a listener its place in the settings.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/action.hpp"
#include "gateway/input.hpp"
#include "modbus/result.hpp"

namespace mbgate::gateway {

/// What a replay must know before the first input.
struct RecordingHead {
  std::string version;   ///< of the gateway that was recorded
  std::string config;    ///< the path of the configuration file
  std::string profiles;  ///< the only folder to look for profiles in; empty: nobody said
  std::string text;      ///< the configuration itself; each of its lines ends with a newline
  Instant start;         ///< when the machine was made
};

/// All of the head but its last line, which begins the inputs.
std::string head_lines(const RecordingHead& head);
/// "500 start": the last line of the head.
void append_start(std::string& out, Instant start);

/// Reads a head line by line.
class HeadReader {
 public:
  /// True once the head is complete. An error says what was expected.
  Result<bool, std::string> read(std::string_view line);
  [[nodiscard]] const RecordingHead& head() const { return head_; }

 private:
  RecordingHead head_;
  bool begun_ = false;
};

/// Appends one line with its newline.
void append_line(std::string& out, const Input& input, Instant at);
/// The settings give the names in reports.
void append_line(std::string& out, const Action& action, const Settings& settings);

/// "end WHY": nothing was recorded after this, although the machine went on.
void append_end(std::string& out, std::string_view why);

/// A line of the configuration, in the head or before other settings; nothing if it is another one.
std::optional<std::string_view> config_line(std::string_view line);
inline bool is_end_line(std::string_view line) { return line.starts_with("end "); }
inline bool is_action_line(std::string_view line) { return line.starts_with('<'); }

struct RecordedInput {
  Instant at;
  Input input;
};

/// The input of a line without its newline, or what is wrong with it. `storage` receives the bytes
/// that the input refers to. Of other settings it is only known that they came.
Result<RecordedInput, std::string> parse_line(std::string_view line,
                                              std::vector<std::uint8_t>& storage);

}  // namespace mbgate::gateway
