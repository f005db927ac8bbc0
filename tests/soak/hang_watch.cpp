// SPDX-License-Identifier: Apache-2.0
#include "soak/hang_watch.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::soak {

void HangWatch::opened(std::size_t bus, Instant now) {
  lines_[bus].heard = now;
  lines_[bus].left = lines_[bus].asked = 0;
}

void HangWatch::read(std::size_t bus, Instant now) {
  opened(bus, now);
  lines_[bus].in_vain = 0;
}

bool HangWatch::is_silent_for_long(std::size_t bus, Instant now) const {
  const bus::BusSettings& settings = plan_.settings.buses[bus];
  Duration patience = settings.hung_after;
  for (unsigned time = 0; time < lines_[bus].in_vain; ++time) {
    patience = std::min(2 * patience, settings.hung_max);
  }
  return settings.line.framing != bus::Framing::tcp &&
         plan_.kinds[bus] != bus::LineKind::virtual_line && patience > Duration{0} &&
         now >= lines_[bus].heard + patience;
}

bool HangWatch::is_due(std::size_t bus, Instant now) const {
  return is_silent_for_long(bus, now) &&
         lines_[bus].left >= plan_.settings.buses[bus].hung_requests;
}

// A stop finds the line as it is.
std::string HangWatch::transmitted(const Flight& flight) {
  Line& line = lines_[flight.bus];
  std::string missed;
  // Between two tries of a stop nothing is opened again.
  const bool is_behind_stop = std::exchange(line.was_stop, flight.is_stop);
  if (!flight.is_stop && !flight.beside_stop && !is_behind_stop &&
      is_silent_for_long(flight.bus, flight.begin) &&
      line.asked >= plan_.settings.buses[flight.bus].hung_requests) {
    missed = "not opened again";
  } else if (std::exchange(line.must_tell, false)) {
    missed = "not told";
  }
  line.left += flight.is_broadcast ? 0U : 1U;
  line.asked += flight.expects_answer ? 1U : 0U;
  return missed;
}

std::string HangWatch::restarted(std::size_t bus, Instant now) {
  const bool due = is_due(bus, now);
  lines_[bus].must_tell = lines_[bus].in_vain++ == 0;
  return due ? "" : "opened again without a reason";
}

std::string HangWatch::told(std::size_t bus) {
  return std::exchange(lines_[bus].must_tell, false) ? "" : "told wrongly";
}

}  // namespace mbgate::soak
