// SPDX-License-Identifier: Apache-2.0
// Notices that a serial adapter is dead though it seems alive: it takes what is transmitted, and
// nothing at all is heard. USB adapters hang like that until they are closed and opened again. All
// devices may as well be switched off, which looks the same: so it is done ever less often.
#pragma once

#include "bus/instant.hpp"
#include "bus/settings.hpp"

namespace mbgate::bus {

class AdapterWatch {
 public:
  /// The line was opened: silence counts from now on. Virtual lines are not watched, they do not
  /// hang.
  void open(LineKind kind, Instant now);
  /// A byte came, an echo or anything else.
  void note_byte(Instant now);
  /// A request left that is to be answered.
  void note_request() { ++requests_; }

  /// Was nothing heard for `hung_after` (doubled at each reopening, up to `hung_max`), in which at
  /// least `hung_requests` left?
  [[nodiscard]] bool is_hung(const BusSettings& settings, Instant now) const;
  /// It is being opened again, because it is hung. True: for the first time since something was
  /// heard.
  bool note_reopening();

  [[nodiscard]] Duration silence(Instant now) const { return now - silent_since_; }
  [[nodiscard]] unsigned requests() const { return requests_; }

 private:
  [[nodiscard]] Duration patience(const BusSettings& settings) const;

  LineKind kind_ = LineKind::virtual_line;
  Instant silent_since_;
  unsigned requests_ = 0;    ///< that left since then
  unsigned reopenings_ = 0;  ///< in vain so far
};

}  // namespace mbgate::bus
