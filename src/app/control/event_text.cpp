// SPDX-License-Identifier: Apache-2.0
#include "app/control/event_text.hpp"

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <cstdio>

#include "app/control/utc_text.hpp"
#include "app/control/utf8.hpp"

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
  return "id: " + std::to_string(event.id) +
         "\nevent: journal\ndata: " + boost::json::serialize(data) + "\n\n";
}

std::string lost_text(std::uint64_t lost) {
  return "event: lost\ndata: {\"lost\":" + std::to_string(lost) + "}\n\n";
}

}  // namespace mbgate::app
