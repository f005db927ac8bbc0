// SPDX-License-Identifier: Apache-2.0
#include "bus/health/adapter_watch.hpp"

#include <algorithm>

namespace mbgate::bus {

void AdapterWatch::open(LineKind kind, Instant now) {
  kind_ = kind;
  silent_since_ = now;
  requests_ = 0;
}

void AdapterWatch::note_byte(Instant now) {
  silent_since_ = now;
  requests_ = 0;
  reopenings_ = 0;
}

bool AdapterWatch::is_hung(const BusSettings& settings, Instant now) const {
  const bool is_watched = kind_ != LineKind::virtual_line ||
                          (settings.line.remote && settings.line.framing != Framing::tcp);
  return is_watched && settings.hung_after > Duration::zero() &&
         requests_ >= settings.hung_requests && silence(now) >= patience(settings);
}

bool AdapterWatch::note_reopening() { return reopenings_++ == 0; }

Duration AdapterWatch::patience(const BusSettings& settings) const {
  Duration patience = settings.hung_after;
  for (unsigned i = 0; i < reopenings_ && patience < settings.hung_max; ++i) {
    patience *= 2;
  }
  return std::max(settings.hung_after, std::min(patience, settings.hung_max));
}

}  // namespace mbgate::bus
