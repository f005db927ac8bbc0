// SPDX-License-Identifier: Apache-2.0
// Server-sent events (text/event-stream, in the HTML standard): from their bytes to events, and to
// lines for people.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "ctl/request/repetition.hpp"

namespace mbgate::ctl {

struct ServerEvent {
  std::string name;
  std::string data;
};

/// Bytes may be cut anywhere. Ids are not kept.
class EventReader {
 public:
  /// The events that these bytes complete. An exception: a line has no end.
  std::vector<ServerEvent> take(std::string_view bytes);

 private:
  /// Without its end. True if it ends an event.
  bool take_line(std::string_view line);

  std::string line_;
  ServerEvent event_;
};

/// Gives the events of a GET to `take`, as follow_control() does with pieces. Returns why it has
/// ended; also where `take` threw, because something is not as this version of mbgated sends it.
std::string follow_events(const std::string& place, const std::string& target,
                          const Interruption& interruption,
                          const std::function<bool(const ServerEvent&)>& take);

/// "22:10:00 warning device axis-x: does not answer any more", in local time; or how many are
/// missing. An exception says what is not as mbgated sends it.
std::string event_line(const ServerEvent& event);

}  // namespace mbgate::ctl
