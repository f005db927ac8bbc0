// SPDX-License-Identifier: Apache-2.0
// Detects a hung serial adapter: it accepts what is transmitted, but nothing at all is received. A
// hung USB adapter stays like that until it is closed and opened again. It looks the same when all
// devices are switched off, so the adapter is reopened less and less often.
#pragma once

#include <algorithm>

#include "bus/instant.hpp"
#include "bus/settings.hpp"

namespace mbgate::bus {

class AdapterWatch {
 public:
  /// The line was opened: the silence is measured from now on. Virtual lines do not hang and are
  /// not watched.
  void open(LineKind kind, Instant now) {
    kind_ = kind;
    silent_since_ = now;
    requests_ = 0;
  }
  /// A byte was received, of an echo or of anything else.
  void note_byte(Instant now) {
    silent_since_ = now;
    requests_ = 0;
    reopenings_ = 0;
  }
  /// A request that expects an answer was sent.
  void note_request() { ++requests_; }

  /// Was nothing received for `hung_after` (doubled at each reopening, up to `hung_max`), while at
  /// least `hung_requests` requests were sent?
  [[nodiscard]] bool is_hung(const BusSettings& settings, Instant now) const {
    const bool is_watched = kind_ != LineKind::virtual_line ||
                            (settings.line.remote && settings.line.framing != Framing::tcp);
    return is_watched && settings.hung_after > Duration::zero() &&
           requests_ >= settings.hung_requests && silence(now) >= patience(settings);
  }
  /// The adapter is being reopened because it is hung. Returns true for the first reopening since
  /// something was received.
  bool note_reopening() { return reopenings_++ == 0; }

  [[nodiscard]] Duration silence(Instant now) const { return now - silent_since_; }
  [[nodiscard]] unsigned requests() const { return requests_; }

 private:
  [[nodiscard]] Duration patience(const BusSettings& settings) const {
    Duration patience = settings.hung_after;
    for (unsigned i = 0; i < reopenings_ && patience < settings.hung_max; ++i) {
      patience *= 2;
    }
    return std::max(settings.hung_after, std::min(patience, settings.hung_max));
  }

  LineKind kind_ = LineKind::virtual_line;
  Instant silent_since_;
  unsigned requests_ = 0;    ///< sent since then
  unsigned reopenings_ = 0;  ///< without success so far
};

}  // namespace mbgate::bus
