// SPDX-License-Identifier: Apache-2.0
// The line discipline of a connection to a Modbus TCP server: several transactions at a time, told
// apart by transaction identifiers of our own. A late answer cannot be mistaken for another one
// (Messaging on TCP/IP V1.0b, 4.4.1): it is dropped, but shows that its device is there.
//
// A server that does not return the identifiers (`check_transaction = false`) gets one transaction
// at a time. As on a serial line, an answer then belongs to the oldest request that it fits.
#pragma once

#include <algorithm>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "bus/action_queue.hpp"
#include "bus/connection_use.hpp"
#include "bus/counters.hpp"
#include "bus/job.hpp"
#include "bus/line_end.hpp"
#include "bus/settings.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::bus {

/// Transactions whose late answers are still recognised.
inline constexpr std::size_t kMostAsked = 64;

class TcpDiscipline {
 public:
  /// `settings` must outlive this object and always be those in force.
  TcpDiscipline(const BusSettings& settings, BusCounters& counters, ConnectionUse& use)
      : settings_(settings), counters_(counters), use_(use) {}

  /// The connection is there, and new: nothing of before counts any more. Without identifiers it is
  /// listened to until then.
  void open(Instant now, LineKind kind, Instant listen_until);
  /// A connection needs no silence but the `gap` that is asked for. Where the last one was closed
  /// right after an answer, this one is given the time to be closed too. Nothing is sent behind a
  /// part of an answer that nobody waits for: the next answer would be taken for its rest.
  [[nodiscard]] Instant ready_at(Duration gap) const {
    return std::max({quiet_since_ + gap, use_.closes_by(), ready_first_at_, listening_until_,
                     stray_part_until().value_or(Instant::min())});
  }
  /// Transmits now; `transaction`, which gets the response, must outlive its end. No broadcasts.
  /// Returns the ADU.
  /// Without identifiers, an answer that fits one of `owed` first, which is no try of its own, is
  /// refused, once.
  FrameBytes begin(Transaction& transaction, const drive::DeviceTiming& timing, OwedAnswers owed,
                   Instant now);
  /// A stop waits only for a server that is not ready yet (`connect_delay`): it would be lost.
  [[nodiscard]] Instant ready_for_stop_at() const {
    return std::max(quiet_since_, ready_first_at_);
  }
  [[nodiscard]] Instant possible_at() const { return quiet_since_; }
  /// The running transaction has so long for its response, and no longer than its timeout.
  void limit_wait(const Transaction& transaction, Duration longest);
  /// The end of the response timeout, without identifiers. With them no device owes anything to
  /// another connection.
  [[nodiscard]] std::optional<Instant> response_due() const {
    return settings_.check_transaction || flights_.empty() ? std::nullopt
                                                           : std::optional(flights_[0].due);
  }
  /// A late answer, each once. Nobody else is heard on a connection.
  std::optional<UnsolicitedFrame> take_unsolicited() { return unsolicited_.take(); }
  /// Gives up all running transactions: nothing of them will be reported.
  void abort();

  void handle_bytes(modbus::Bytes bytes, Instant now);
  void handle_deadline(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const;
  /// The ends of running transactions, each once.
  std::optional<LineEnd> take_end() { return ends_.poll(); }
  /// Once: the connection is of no use, because its stream cannot be followed any further, or
  /// because nothing comes.
  std::optional<LineFault> take_fault() { return std::exchange(fault_, std::nullopt); }
  [[nodiscard]] LineState state(Instant /*now*/) const {
    return flights_.empty() ? LineState::idle : LineState::waiting_for_reply;
  }

 private:
  /// A transaction whose answer is waited for.
  struct Flight {
    std::uint16_t identifier;
    Transaction* transaction;
    Instant sent;
    Instant due;                ///< the end of the response timeout
    Instant response_deadline;  ///< the same, or earlier because a stop waits
  };
  /// One that may be answered; without identifiers also one that was, and may be once more.
  struct Sent {
    std::uint16_t identifier;
    std::uint8_t address;
    std::uint8_t unit;
  };

  /// By then the rest of a part that nobody waits for has come, or framing is lost.
  [[nodiscard]] std::optional<Instant> stray_part_until() const {
    const bool is_there = !stream_.empty() && padding_ == 0 && flights_.empty();
    return is_there ? std::optional(quiet_since_ + kNetworkSlack) : std::nullopt;
  }
  std::uint16_t new_identifier();
  /// Takes one answer off the stream. False: there is no whole one, or framing is lost.
  bool take_answer(Instant now);
  void match(const modbus::MbapAdu& answer, Instant now);
  /// Drops bytes behind an exception that its length has promised and that begin no answer.
  void skip_padding();

  const BusSettings& settings_;
  Instant ready_first_at_ = Instant::min();  // of this connection
  BusCounters& counters_;
  ConnectionUse& use_;
  std::vector<Flight> flights_;
  OwedAnswers owed_;  // without identifiers: what may still come from the device
  Instant listening_until_ = Instant::min();
  std::uint16_t last_identifier_ = 0;
  std::vector<std::uint8_t> stream_;  // less than an answer, between calls
  std::size_t padding_ = 0;           // so many bytes that are no answer may come next
  Instant quiet_since_;               // the last byte in either direction
  ActionQueue<LineEnd> ends_;
  std::deque<Sent> asked_;  // the newest kMostAsked
  Untold<UnsolicitedFrame, kMostAsked> unsolicited_;
  std::optional<LineFault> fault_;
};

}  // namespace mbgate::bus
