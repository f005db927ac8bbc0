// SPDX-License-Identifier: Apache-2.0
#include "app/control/event_text.hpp"

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <cstdio>

#include "app/utc_text.hpp"
#include "app/utf8.hpp"

namespace mbgate::app {
namespace {

/// "2026-11-24T22:10:00.123Z"
std::string instant_text(std::chrono::system_clock::time_point instant) {
  using std::chrono::floor;
  const auto rest =
      floor<std::chrono::milliseconds>(instant - floor<std::chrono::seconds>(instant));
  char milliseconds[sizeof ".123Z"];
  std::snprintf(milliseconds, sizeof milliseconds, ".%03dZ", static_cast<int>(rest.count()));
  return utc_second(instant) + milliseconds;
}

}  // namespace

std::string event_text(const JournalEvent& event) {
  const boost::json::object data{{"at", instant_text(event.at)},
                                 {"level", level_word(event.level)},
                                 {"text", valid_utf8(event.text)}};
  return server_event(event.id, "journal", boost::json::serialize(data));
}

std::string server_event(std::uint64_t id, std::string_view name, std::string_view data) {
  return "id: " + std::to_string(id) + "\nevent: " + std::string(name) +
         "\ndata: " + std::string(data) + "\n\n";
}

std::string lost_text(std::uint64_t lost) {
  return "event: lost\ndata: {\"lost\":" + std::to_string(lost) + "}\n\n";
}

}  // namespace mbgate::app
