// SPDX-License-Identifier: Apache-2.0
#include "app/control/event_text.hpp"

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>

#include "app/utc_text.hpp"
#include "app/utf8.hpp"

namespace mbgate::app {

std::string event_text(const JournalEvent& event) {
  const boost::json::object data{{"at", utc_millisecond(event.at)},
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
