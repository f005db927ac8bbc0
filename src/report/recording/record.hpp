// SPDX-License-Identifier: Apache-2.0
// A recording of the machine as text: a head with the configuration, then a line for each input,
// with its instant in nanoseconds, and one for each action, in the order in which they happened.
//
//   mbgate recording 1                    < open 0
//   version 0.1.0                         517 opened 0 virtual
//   profiles /srv/profiles                < report bus line-a is open
//   config /etc/mbgate/mbgate.toml        633 connected 0 0 192.0.2.1 0
//   | [[bus]]                             701 read 0 0 000100000006010300000001
//   | name = "line-a"                     < transmit 0 010300000001840A
//   500 start                             ...
//
// A configuration of several files has a "config" with its lines for each of them, in their order:
// put together they might say a table twice, or read on where a file ends within one. Other
// settings are recorded as in the head: the files of their configuration, and "900 settings".
// Bytes are hexadecimal; a client is its number, a bus or a listener its place in the settings.
//
// To change
// - the text of an input or an action: record; writing it: io/recorder, app/recording; replaying
//   it: ctl/replay/replay; the report of a replay: ctl/replay/replay_command.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gateway/action.hpp"
#include "gateway/input.hpp"
#include "modbus/result.hpp"

namespace mbgate::report {

using gateway::Action;
using gateway::Input;
using gateway::Instant;
using gateway::Settings;

/// A file of a configuration.
struct ConfigFile {
  std::string path;
  std::string text;  ///< as it is read again, each of its lines ends with a newline
};

/// "config PATH" and the lines of the file, for each in order.
std::string config_lines(const std::vector<ConfigFile>& files);

/// Reads them line by line.
class ConfigReader {
 public:
  /// False if the line is none of a configuration.
  bool read(std::string_view line);
  /// The files that were read since the last call.
  std::vector<ConfigFile> take() { return std::exchange(files_, {}); }

 private:
  std::vector<ConfigFile> files_;
};

/// What a replay must know before the first input.
struct RecordingHead {
  std::string version;             ///< of the gateway that was recorded
  std::string profiles;            ///< the only folder to look for profiles in; empty: nobody said
  std::vector<ConfigFile> config;  ///< at least one file
  Instant start;                   ///< when the machine was made
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
  ConfigReader config_;
  bool begun_ = false;
};

/// Appends one line with its newline.
void append_line(std::string& out, const Input& input, Instant at);
/// The settings give the names in reports.
void append_line(std::string& out, const Action& action, const Settings& settings);

/// "end WHY": nothing was recorded after this, although the machine went on.
void append_end(std::string& out, std::string_view why);

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

}  // namespace mbgate::report
