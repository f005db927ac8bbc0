// SPDX-License-Identifier: Apache-2.0
// Finds the response to one request in the bytes that come from an RTU line. Known functions end by
// their predicted length and CRC, at once; unknown ones by silence with a good CRC. Gaps between
// bytes mean nothing by themselves, because a USB adapter's gaps are not the wire's; t1.5 is never
// enforced. Good frames that are no response to it are told, and while nothing was asked all are.
#pragma once

#include <boost/container/static_vector.hpp>
#include <optional>

#include "bus/counters.hpp"
#include "bus/instant.hpp"
#include "bus/job.hpp"
#include "bus/verdict.hpp"
#include "modbus/response.hpp"

namespace mbgate::bus {

/// Slack for what lies between the wire and us: adapters hold received bytes back up to 16 ms.
inline constexpr Duration kAdapterSlack = std::chrono::milliseconds(20);

/// A whole frame and what may stand before or behind it in the same piece.
inline constexpr std::size_t kMostBuffered = 1024;

class RtuFramer {
 public:
  RtuFramer(const modbus::RtuTiming& timing, BusCounters& counters);

  /// From now on the answer to `transaction` is looked for; it must outlive the search.
  void expect(const Transaction& transaction);
  /// Nothing is asked any more. What is left of the bytes is stray.
  void listen();
  /// Bytes as they came in. After a verdict other than none comes expect(), again() or listen().
  Verdict add(modbus::Bytes bytes, Instant now);
  /// The response was none: the search goes on in what came behind it.
  Verdict again(Instant now);
  /// Time has passed: silence may end a frame or show that one stays incomplete.
  Verdict handle_deadline(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const;
  /// Has an answer begun that is still incomplete? The response timeout is then over, its rest has
  /// its own time.
  [[nodiscard]] bool in_progress() const { return begun_at_.has_value(); }
  /// Is a frame complete as far as can be seen, and only silence can tell?
  [[nodiscard]] bool awaits_silence() const { return bad_crc_ || opaque_; }
  [[nodiscard]] const modbus::Pdu& response() const { return *response_; }
  /// When the first byte of the response came.
  [[nodiscard]] Instant response_began() const { return response_began_; }
  /// A good frame that answers nothing that was asked, each once.
  std::optional<Stray> take_stray() { return strays_.take(); }

 private:
  enum class Step : std::uint8_t { wait, again, response };

  /// Counts what is left as stray and forgets it, until the next silence.
  void discard();
  void skip_noise();
  void drop(std::size_t bytes);
  Step look(Instant now);
  Step look_at_candidate();
  Step look_at_stranger();
  [[nodiscard]] modbus::PduLength candidate_length() const;
  [[nodiscard]] bool has_other_length() const;
  [[nodiscard]] modbus::Bytes buffered() const { return {buffer_.data(), buffer_.size()}; }
  Verdict end_by_silence();
  Verdict search(Instant now);
  void note_stray(modbus::Bytes frame);
  void give_up_buffer();
  void accept(modbus::Bytes pdu);

  modbus::RtuTiming timing_;
  Duration silence_;  // ends frames of unknown length
  BusCounters& counters_;
  const Transaction* transaction_ = nullptr;
  boost::container::static_vector<std::uint8_t, kMostBuffered> buffer_;
  Instant last_byte_;
  std::optional<Instant> begun_at_;  // first byte of what may be the answer
  unsigned noise_skipped_ = 0;
  bool discarding_ = false;  // the buffer is no frame: everything until silence is stray
  bool bad_crc_ =
      false;  // a complete candidate with a wrong CRC; silence must confirm that it is complete
  bool opaque_ = false;  // a candidate that only silence ends
  std::optional<modbus::Pdu> response_;
  Instant response_began_;
  Strays<kMostStrays> strays_;
};

}  // namespace mbgate::bus
