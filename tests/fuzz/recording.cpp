// SPDX-License-Identifier: Apache-2.0
// Any text as a recording: it is replayed, or it is said what is wrong with it. Each of its lines
// that is an input is written as it was read.
#include <sstream>
#include <string>
#include <vector>

#include "ctl/replay/replay.hpp"
#include "fuzz/fuzz.hpp"
#include "report/recording/record.hpp"

namespace mbgate::fuzz::recording_target {
namespace {

// More would make each run slow: a recording may have any number of buses.
constexpr std::size_t kMostBuses = 20;

std::size_t count_of(std::string_view text, std::string_view word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1)) {
    ++count;
  }
  return count;
}

void check_line(const std::string& line) {
  std::vector<std::uint8_t> storage;
  const auto parsed = report::parse_line(line, storage);
  require(parsed || !parsed.error().empty(), "a line that is none says why");
  if (!parsed || std::holds_alternative<gateway::SettingsChanged>(parsed->input)) {
    return;
  }
  std::string once;
  report::append_line(once, parsed->input, parsed->at);
  require(once.ends_with('\n') && count_of(once, "\n") == 1, "an input is a line");
  once.pop_back();
  std::vector<std::uint8_t> again_storage;
  const auto again = report::parse_line(once, again_storage);
  require(again.has_value(), "what was written is read");
  std::string twice;
  report::append_line(twice, again->input, again->at);
  twice.pop_back();
  require(once == twice, "and written as before");
}

}  // namespace

MBGATE_FUZZ_TARGET(recording) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    check_line(line);
  }
  if (count_of(text, "[bus]]") > kMostBuses) {
    return 0;
  }
  std::istringstream recording(text);
  const auto outcome = ctl::replay(recording, MBGATE_SOURCE_DIR "/tests/config/profiles");
  require(!(outcome.bad && outcome.difference), "a recording is bad, or differs");
  require(!outcome.bad || !outcome.bad->reason.empty(), "a bad recording says why");
  require(!outcome.difference || outcome.difference->recorded != outcome.difference->replayed,
          "a difference is one");
  return 0;
}

}  // namespace mbgate::fuzz::recording_target
