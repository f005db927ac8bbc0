// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/event_reader.hpp"

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <ctime>
#include <stdexcept>
#include <utility>

#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

/// `at` is in UTC: "2026-11-24T22:10:00.123Z".
std::string local_time(const std::string& at) {
  std::tm utc{};
  if (::strptime(at.c_str(), "%Y-%m-%dT%H:%M:%S", &utc) == nullptr) {
    throw std::invalid_argument("\"" + at + "\" is no time");
  }
  const std::time_t instant = ::timegm(&utc);
  std::tm local{};
  ::localtime_r(&instant, &local);
  char text[sizeof "22:10:00"];
  std::strftime(text, sizeof text, "%H:%M:%S", &local);
  return text;
}

}  // namespace

std::vector<ServerEvent> EventReader::take(std::string_view bytes) {
  std::vector<ServerEvent> events;
  for (const char byte : bytes) {
    if (byte != '\n') {
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

std::string event_line(const ServerEvent& event) {
  const boost::json::value json = boost::json::parse(event.data);
  const boost::json::object& data = json.as_object();
  if (event.name == "lost") {
    const auto lost = data.at("lost").to_number<std::uint64_t>();
    return std::to_string(lost) + (lost == 1 ? " line is" : " lines are") +
           " missing here: mbgated does not keep them any more";
  }
  const auto word = [&](const char* key) { return visible_text(data.at(key).as_string()); };
  return local_time(word("at")) + " " + word("level") + " " + word("text");
}

}  // namespace mbgate::ctl
