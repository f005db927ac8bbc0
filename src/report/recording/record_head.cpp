// SPDX-License-Identifier: Apache-2.0
// The head of a recording: the configuration, and the start.
#include <algorithm>
#include <fmt/core.h>

#include "base/text.hpp"
#include "report/recording/record.hpp"

namespace mbgate::report {
namespace {

/// Takes `key` and a space off the front of the line.
bool take_key(std::string_view& line, std::string_view key) {
  if (!line.starts_with(key) || line.size() <= key.size() || line[key.size()] != ' ') {
    return false;
  }
  line.remove_prefix(key.size() + 1);
  return true;
}

}  // namespace

void append_start(std::string& out, Instant start) {
  out += fmt::format("{} start\n", start.time_since_epoch().count());
}

void append_end(std::string& out, std::string_view why) { ((out += "end ") += why) += '\n'; }

std::string config_lines(const std::vector<ConfigFile>& files) {
  std::string out;
  for (const auto& file : files) {
    out += fmt::format("config {}\n", file.path);
    const std::string_view text = file.text;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      ((out += "| ") += text.substr(begin, end - begin)) += '\n';
      begin = end + 1;
    }
  }
  return out;
}

std::string head_lines(const RecordingHead& head) {
  std::string out = fmt::format("mbgate recording 1\nversion {}\n", head.version);
  if (!head.profiles.empty()) {
    out += fmt::format("profiles {}\n", head.profiles);
  }
  return out + config_lines(head.config);
}

bool ConfigReader::read(std::string_view line) {
  if (take_key(line, "config")) {
    files_.push_back({std::string(line), {}});
    return true;
  }
  if (files_.empty() || !take_key(line, "|")) {
    return false;
  }
  (files_.back().text += line) += '\n';
  return true;
}

Result<bool, std::string> HeadReader::read(std::string_view line) {
  if (!begun_) {
    begun_ = line == "mbgate recording 1";
    return begun_ ? Result<bool, std::string>(false)
                  : std::string("expected \"mbgate recording 1\": this is not a recording");
  }
  if (config_.read(line)) {
    return false;
  }
  std::string_view value = line;
  if (take_key(value, "version")) {
    head_.version = value;
  } else if (take_key(value, "profiles")) {
    head_.profiles = value;
  } else if (line.ends_with(" start")) {
    const auto start = integer_in<std::int64_t>(line.substr(0, line.size() - 6));
    head_.config = config_.take();
    if (!start || head_.config.empty()) {
      return std::string(start ? "expected the configuration before the start"
                               : "expected an instant in nanoseconds before \"start\"");
    }
    head_.start = Instant(gateway::Duration(*start));
    return true;
  } else {
    return fmt::format("expected a line of the configuration or the start, found \"{}\"", line);
  }
  return false;
}

}  // namespace mbgate::report
