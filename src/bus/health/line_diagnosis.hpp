// SPDX-License-Identifier: Apache-2.0
// What is noticed about a line and its devices apart from the answers themselves: the quality of
// the answers, frames that answer no pending request (late answers, other clients, echoes), a line
// that is never silent. Each finding is reported once until it is over.
#pragma once

#include <optional>
#include <utility>

#include "bus/bus_action.hpp"
#include "bus/durations.hpp"
#include "bus/health/line_quality.hpp"
#include "bus/instant.hpp"
#include "bus/parts.hpp"
#include "bus/serial/serial_discipline.hpp"

namespace mbgate::bus {

// Whether a line has an echo though the settings say that it has none: own requests are heard.

class DeniedEcho {
 public:
  /// What was just sent was heard. True: that proves an echo, and was not told yet.
  bool note_heard(Instant now) {
    if (std::exchange(is_heard_, true)) {
      return false;
    }
    const bool is_soon = in_row_ > 0 && now <= last_ + kWithin;
    last_ = now;
    if (!is_found()) {
      in_row_ = is_soon ? in_row_ + 1 : 1;
    }
    return is_found() && !std::exchange(reported_, true);
  }
  /// A transmission has ended. A read that was answered without its echo shows that there is none.
  void note_ended(bool is_answered_read) {
    if (!std::exchange(is_heard_, false) && is_answered_read) {
      in_row_ = 0;
    }
  }
  [[nodiscard]] bool is_found() const { return in_row_ == kEchoesToTell; }

 private:
  // Another client may have asked for the same a moment before, and an adapter kept that; hardly
  // for two requests in a row, so soon after each other.
  static constexpr unsigned kEchoesToTell = 2;
  static constexpr Duration kWithin = std::chrono::minutes(1);

  bool is_heard_ = false;  // since the last transmission ended
  unsigned in_row_ = 0;
  Instant last_ = Instant::min();
  bool reported_ = false;
};

// How busy a line is: the share of time in which something was transmitted, an answer was waited
// for, or the silence after it ran; and how many requests waited for it for long.

/// A client notices it if a request waits for so long before it is sent.
inline constexpr Duration kLongWait = std::chrono::milliseconds(500);

/// Requests that were sent for the first time, and how many of them waited for kLongWait or longer.
struct LineWaits {
  unsigned all = 0;
  unsigned are_long = 0;
};

class LineLoad {
 public:
  /// Is a transmission under way at `now`? If none is, the line can be used again at `free_at`.
  void note(bool is_busy, Instant now, Instant free_at);
  /// A request is sent for the first time, and has waited for the line so long.
  void note_wait(Duration waited, Instant now);
  [[nodiscard]] bool is_busy() const { return busy_since_.has_value(); }
  /// How long it was busy in all.
  [[nodiscard]] Duration total(Instant now) const;
  /// Of the last ten seconds that are over, or of the time since the first transmission if that is
  /// less.
  [[nodiscard]] unsigned percent(Instant now) const;
  /// Of the same time.
  [[nodiscard]] LineWaits waits(Instant now) const;

 private:
  void go_on(Instant now);
  void end_busy(Instant at);

  std::optional<Instant> window_began_;  // nothing was transmitted yet
  std::optional<Instant> busy_since_;    // or later, if the time until then counts already
  Instant counted_until_ = Instant::min();
  Duration total_{0};                 // without the time since busy_since_
  Duration busy_{0};                  // in this window
  std::optional<Duration> before_{};  // in the one before
  LineWaits waits_;                   // the same of these
  LineWaits waits_before_;
};

/// The request of a transmission that has ended.
struct Asked {
  std::uint8_t address;
  bool is_read;
  bool wants_answer;
  bool is_first;  ///< no repetition
  Instant sent;
  LineEnd::How how;  ///< no_response also if a server did not reach it; sent also if a stop cut it
};

/// Around the silences that the specification asks for, and beyond.
extern const std::array<Duration, 16> kSilenceBounds;

class LineDiagnosis {
 public:
  explicit LineDiagnosis(Parts& parts) : parts_(parts) {}

  void note_opened();
  /// A transmission begins: how long the line was silent before it.
  void note_begins(Instant now);
  /// Bytes were received; `asked`: while a request was pending.
  void note_bytes(bool asked, Instant now);
  /// A valid frame came that answers no pending request.
  void note_unsolicited(const UnsolicitedFrame& unsolicited);
  void note_ended(const Asked& asked, const LineEnd& end, Instant now);
  /// It was answered: how long that took.
  void note_times(const Job& job, const LineEnd& end, Instant now);
  /// What was seen at these addresses was seen of other devices.
  void note_other_devices(const Addresses& addresses);
  /// The server takes requests and does not answer. Returns true the first time since something was
  /// received from it.
  bool note_unanswered_connection() {
    return !std::exchange(replacement_reported_, true) || parts_.line.use().has_answered();
  }
  /// A good frame of the device came. Returns true if it was offline, and is back: then others that
  /// have their supply from the same place may be, too.
  bool note_heard(std::uint8_t address, Instant now);
  void notify(DeviceNotice::Kind kind, std::uint8_t address);

  [[nodiscard]] const LineQuality& quality() const { return quality_; }
  /// How busy the line is.
  [[nodiscard]] const LineLoad& load() const { return load_; }
  [[nodiscard]] LineLoad& load() { return load_; }
  /// The silences before transmissions; empty for a connection.
  [[nodiscard]] const Histogram& silences() const { return silences_; }
  void clear_counters() { silences_ = Histogram(kSilenceBounds); }
  /// When the last frame came that counts as foreign; Instant::min(): none did.
  [[nodiscard]] Instant last_foreign() const { return last_foreign_; }
  /// The same for one that was a request: only another client sends these.
  [[nodiscard]] Instant last_foreign_request() const { return last_foreign_request_; }
  /// When the line was last without silence for too long; Instant::min(): never.
  [[nodiscard]] Instant last_never_silent() const { return last_never_silent_; }
  [[nodiscard]] NoticedEcho echo() const {
    return denied_echo_.is_found() ? NoticedEcho::denied : parts_.line.noticed_echo();
  }

 private:
  void note_foreign(const UnsolicitedFrame& unsolicited);
  bool note_second_answer(const UnsolicitedFrame& unsolicited);
  bool note_misfit(const UnsolicitedFrame& unsolicited);
  void note_silence(const Asked& asked, Instant now);
  void tell_quality(std::uint8_t address);

  Parts& parts_;
  LineQuality quality_;
  LineLoad load_;
  Histogram silences_{kSilenceBounds};
  bool never_silent_reported_ = false;
  bool foreign_reported_ = false;
  Instant last_foreign_ = Instant::min();
  Instant last_foreign_request_ = Instant::min();
  Instant last_never_silent_ = Instant::min();
  bool replacement_reported_ = false;
  bool frame_heard_ = false;  // an unsolicited one, since the last transmission ended
  DeniedEcho denied_echo_;    // notes nothing unless the settings say that there is no echo
};

}  // namespace mbgate::bus
