// SPDX-License-Identifier: Apache-2.0
// Finds the response to one request in the characters that come from an ASCII line: ':' begins a
// frame, and begins it anew where one had begun already, CR LF ends it, and its characters are
// never further apart than 1 s (Serial Line V1.02, 2.5.2.1). All of them together have no more than
// that second beyond their time on the wire, or one character in each second would hold the line
// for minutes. CR or LF alone ends a frame whose LRC is right.
#pragma once

#include <array>
#include <optional>

#include "bus/counters.hpp"
#include "bus/line_end.hpp"
#include "modbus/frames.hpp"
#include "modbus/rtu_timing.hpp"

namespace mbgate::bus {

/// From one character of a frame to the next.
inline constexpr Duration kLongestCharacterGap = std::chrono::seconds(1);

class AsciiFramer {
 public:
  /// `slack` is what a frame may pause in all while a stop waits, and the silence behind a CR that
  /// ends it alone.
  AsciiFramer(const modbus::RtuTiming& timing, Duration slack, BusCounters& counters)
      : timing_(timing), slack_(slack), counters_(counters) {}
  void set_slack(Duration slack) { slack_ = slack; }

  /// From now on the answer to `transaction` is looked for; it must outlive the search. `sent`: the
  /// end of emission, if the line keeps its pace.
  void expect(const Transaction& transaction, Instant sent = Instant::min());
  /// A stop waits: what has begun goes on no longer than it must, but until `due`.
  void hurry(Instant due) { hurried_ = due; }
  /// Nothing is asked any more. A frame that has begun goes on: it may be a late answer.
  void listen();
  /// Another connection: what has begun does not go on.
  void forget();
  /// Characters as they came in. After a verdict other than none comes expect(), again() or
  /// listen().
  Verdict add(modbus::Bytes bytes, Instant now);
  /// The response was none: the search goes on in what came behind it.
  Verdict again(Instant now);
  /// Time has passed: a frame may prove to stay incomplete.
  Verdict handle_deadline(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const;
  /// Has a frame begun that may be the answer? The response timeout is then over, its rest has its
  /// own time.
  [[nodiscard]] bool in_progress() const;
  /// Has a frame begun, whoever it is for?
  [[nodiscard]] bool is_amid_frame() const { return !buffer_.empty(); }
  /// Is a frame complete if no LF follows its CR?
  [[nodiscard]] bool awaits_silence() const { return is_whole_; }
  [[nodiscard]] const FoundResponse& found() const { return found_; }
  /// A good frame that answers nothing that was asked, each once.
  std::optional<UnsolicitedFrame> take_unsolicited() { return unsolicited_.take(); }

 private:
  Verdict take(std::uint8_t character, Instant now);
  Verdict judge(Instant now);
  Verdict keep_rest(Verdict verdict, modbus::Bytes rest);
  [[nodiscard]] std::optional<modbus::AsciiContent> content() const;
  [[nodiscard]] bool ends_well() const;
  /// Counts what has been gathered as stray and forgets it.
  void discard();

  modbus::RtuTiming timing_;
  Duration slack_;
  BusCounters& counters_;
  const Transaction* transaction_ = nullptr;
  bool is_paced_ = false;
  std::optional<Instant> hurried_;
  modbus::AsciiBytes buffer_;            // empty, or a frame from its ':' on
  bool is_whole_ = false;                // but for the LF that may follow its CR
  bool is_earlier_ = false;              // it began before what is asked was transmitted
  std::array<std::uint8_t, 3> start_{};  // of an answer: ':' and the address
  std::size_t longest_ = 0;              // that an answer can be
  Instant last_character_;
  FoundResponse found_;
  Instant began_;             // the frame in the buffer, or the last one
  bool began_first_ = false;  // of all since expect()
  std::size_t taken_ = 0;     // characters since then
  modbus::AsciiBytes rest_;   // what came behind the response
  Untold<UnsolicitedFrame, kMostUnsolicited> unsolicited_;
};

}  // namespace mbgate::bus
