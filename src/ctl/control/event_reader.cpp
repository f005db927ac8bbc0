// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/event_reader.hpp"

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <ctime>
#include <fmt/chrono.h>
#include <stdexcept>
#include <utility>

#include "ctl/control/control_shell.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

constexpr std::size_t kLongestLine = 1 << 20;

/// `at` is in UTC: "2026-11-24T22:10:00.123Z".
std::string local_time(const std::string& at) {
  std::tm utc{};
  if (::strptime(at.c_str(), "%Y-%m-%dT%H:%M:%S", &utc) == nullptr) {
    throw std::invalid_argument(fmt::format("\"{}\" is not a time", at));
  }
  return fmt::format("{:%H:%M:%S}", fmt::localtime(::timegm(&utc)));
}

}  // namespace

std::vector<ServerEvent> EventReader::take(std::string_view bytes) {
  std::vector<ServerEvent> events;
  for (const char byte : bytes) {
    if (byte != '\n') {
      if (line_.size() == kLongestLine) {
        throw std::length_error("a line is longer than 1 MB");
      }
      line_ += byte;
    } else if (take_line(std::exchange(line_, {}))) {
      events.push_back(std::exchange(event_, {}));
    }
  }
  return events;
}

bool EventReader::take_line(std::string_view line) {
  if (line.empty()) {
    return !event_.data.empty();
  }
  const std::string_view field = line.substr(0, line.find(':'));
  line.remove_prefix(std::min(field.size() + 1, line.size()));
  if (line.starts_with(' ')) {
    line.remove_prefix(1);
  }
  if (field == "event") {
    event_.name = line;
  } else if (field == "data") {
    event_.data = line;
  }
  return false;
}

std::string follow_events(const std::string& place, const std::string& target,
                          const Interruption& interruption,
                          const std::function<bool(const ServerEvent&)>& take) {
  EventReader reader;
  try {
    return follow_control(place, target, interruption, [&](std::string_view piece) {
      return std::ranges::all_of(reader.take(piece), take);
    });
  } catch (const std::exception& exception) {
    return other_version(exception);
  }
}

std::string event_line(const ServerEvent& event) {
  const boost::json::value json = boost::json::parse(event.data);
  const boost::json::object& data = json.as_object();
  if (event.name == "lost") {
    const auto lost = data.at("lost").to_number<std::uint64_t>();
    return fmt::format("{}{} missing here: mbgated does not keep them any more", lost,
                       lost == 1 ? " line is" : " lines are");
  }
  const auto word = [&](const char* key) { return visible_text(data.at(key).as_string()); };
  return fmt::format("{} {} {}", local_time(word("at")), word("level"), word("text"));
}

}  // namespace mbgate::ctl
