// SPDX-License-Identifier: Apache-2.0
// Finds the response to one request in the bytes that come from an RTU line. Known functions end by
// their predicted length and CRC, at once; unknown ones by silence with a good CRC. Gaps between
// bytes mean nothing by themselves, because a USB adapter's gaps are not the wire's; t1.5 is never
// enforced. Good frames that are no response to it are told, and while nothing was asked all are.
//
// rtu_search says what begins where. What follows a request of another client answers that; what
// was sent itself, and is heard though nobody said so, is no answer.
#pragma once

#include <algorithm>
#include <bitset>
#include <boost/container/static_vector.hpp>
#include <optional>

#include "bus/counters.hpp"
#include "bus/serial/rtu_search.hpp"
#include "modbus/frames.hpp"
#include "modbus/response.hpp"

namespace mbgate::bus {

// Joins a frame that no request waits for and that an adapter delivers in two pieces with a pause
// between. The latency timer of an FTDI can split a late answer like any other frame.

/// A frame that has begun pauses for no longer, and is not longer under way.
inline constexpr Duration kLongestPauses = std::chrono::seconds(1);

class CutFrame {
 public:
  /// The bytes (at least one) were given up as a frame. The first of them came at `began`, the last
  /// at `last`. They are appended to what is kept, unless they began more than kLongestPauses
  /// after it: then that is dropped first. Only what may be the beginning of a frame is kept; where
  /// there is no room for all of it, the oldest pieces are dropped.
  void keep(modbus::Bytes bytes, Instant began, Instant last);
  /// A valid frame that begins in what was kept and ends in the new bytes.
  struct Joined {
    modbus::RtuAdu frame;
    std::size_t taken;  ///< of the new bytes
    bool is_response;   ///< else it is another client's request
    bool after_noise;
    Duration pause;  ///< the longest between its pieces
  };
  /// Completes a kept frame with `bytes`, which began at `began`; what is kept is then dropped.
  /// Nothing if the bytes complete no frame, began more than kLongestPauses after what is kept, or
  /// begin with a valid frame themselves.
  std::optional<Joined> complete(modbus::Bytes bytes, Instant began);

  /// Could `bytes`, which began at `began`, go on with what is kept, and more follow? Not behind a
  /// pause longer than `slack`.
  [[nodiscard]] bool may_go_on(modbus::Bytes bytes, Instant began, Duration slack) const;
  /// Is nothing kept? Then nothing can be completed.
  [[nodiscard]] bool empty() const { return kept_.empty(); }
  /// Is it the beginning of a frame, with `last` the instant of its last byte? One byte is noise.
  [[nodiscard]] bool ends_at(Instant last) const { return kept_.size() > 1 && last_ == last; }

 private:
  using Together = boost::container::static_vector<std::uint8_t, 2 * modbus::kMaxRtuSize>;
  /// What is kept, and these bytes behind it.
  [[nodiscard]] Together joined_with(modbus::Bytes bytes) const;
  void make_room(std::size_t size);

  boost::container::static_vector<std::uint8_t, modbus::kMaxRtuSize> kept_;
  /// Where in `kept_` a piece begins that was given up: a frame may begin with any of them.
  std::bitset<modbus::kMaxRtuSize> begins_;
  Instant last_;
  Duration pause_{0};  // the longest between two pieces
};

class RtuFramer {
 public:
  /// `slack`, or t3.5 if that is longer, is what an answer may pause in all, and the silence that
  /// ends what has no known end.
  RtuFramer(const modbus::RtuTiming& timing, Duration slack, BusCounters& counters)
      : timing_(timing), slack_(std::max(timing.t3_5(), slack)), counters_(counters) {}
  void set_slack(Duration slack) { slack_ = std::max(timing_.t3_5(), slack); }

  /// From now on the answer to `transaction` is looked for; it must outlive the search. A request
  /// like it that begins before `sent` is its echo: the end of emission, if the line keeps its
  /// pace.
  void expect(const Transaction& transaction, Instant sent = Instant::min());
  /// A stop waits, and the response timeout ends at `due` for it. An answer that has begun is
  /// complete by then, or after its time on the wire and the slack, or the wait is over.
  void hurry(Instant due) { hurried_ = due; }
  /// Nothing is asked any more. What is left of the bytes is stray.
  void listen();
  /// Another connection: what was cut does not go on.
  void forget();
  /// Bytes as they came in. After a verdict other than none comes expect(), again() or listen().
  Verdict add(modbus::Bytes bytes, Instant now);
  /// The response was none: the search goes on in what came behind it.
  Verdict again(Instant now);
  /// Time has passed: silence may end a frame or show that one stays incomplete.
  Verdict handle_deadline(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const;
  /// Has an answer begun that is still incomplete? The response timeout is then over, its rest has
  /// its own time.
  [[nodiscard]] bool in_progress() const { return answer_ != Answer::not_begun; }
  /// May what came last go on as a frame, whoever it is for? Then the line is busy for the slack
  /// behind each byte. A single byte behind a complete frame is noise.
  [[nodiscard]] bool is_amid_frame() const;
  /// Is a frame complete as far as can be seen, and only silence can tell?
  [[nodiscard]] bool awaits_silence() const {
    return answer_ != Answer::not_begun && answer_ != Answer::incomplete;
  }
  [[nodiscard]] const FoundResponse& found() const { return found_; }
  /// A good frame that answers nothing that was asked, each once.
  std::optional<UnsolicitedFrame> take_unsolicited() { return unsolicited_.take(); }

 private:
  [[nodiscard]] RtuSearch looker() const { return {buffer_, transaction_, timing_, sent_}; }
  /// Counts what is left as stray and forgets it, until the next silence.
  void discard();
  void give_up_buffer();
  void join_cut();
  Verdict search(bool silence);
  void accept(const RtuFind& response);
  void consume(std::size_t at, std::size_t size);
  Verdict end_by_silence();
  void note_unsolicited(std::size_t at, std::size_t size);

  modbus::RtuTiming timing_;
  Duration slack_;
  BusCounters& counters_;
  const Transaction* transaction_ = nullptr;
  Instant sent_;
  std::optional<Instant> hurried_;
  ReceivedBytes buffer_;
  Instant last_byte_;
  Answer answer_ = Answer::not_begun;
  std::size_t answer_at_ = 0;     // its place among the bytes
  std::size_t given_ = 0;         // bytes since expect()
  bool answers_another_ = false;  // what stands here follows another client's request
  bool discarding_ = false;       // the buffer is no frame: everything until silence is stray
  bool is_behind_frame_ = false;  // without a silence between
  FoundResponse found_;
  CutFrame cut_;
  Untold<UnsolicitedFrame, kMostUnsolicited> unsolicited_;
};

}  // namespace mbgate::bus
