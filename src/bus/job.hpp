// SPDX-License-Identifier: Apache-2.0
// A job: the ordered transactions of one client request on one bus. Nothing comes between them.
// Jobs are owned by the gateway and have a stable address; the bus links them into its queue.
#pragma once

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <boost/container/static_vector.hpp>
#include <boost/intrusive/list_hook.hpp>
#include <boost/intrusive/set_hook.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bus/instant.hpp"
#include "drive/transaction.hpp"
#include "modbus/frames.hpp"

namespace mbgate::bus {

/// The longest frame of any line discipline: ASCII has two characters a byte (Serial Line V1.02,
/// 2.5.2.1).
inline constexpr std::size_t kMaxFrameSize = 513;
using FrameBytes = boost::container::static_vector<std::uint8_t, kMaxFrameSize>;

using drive::Transaction;

/// Client addresses take turns on a bus. This is the number of one client address.
enum class FairnessKey : std::uint32_t {};

/// Stops are sent first, then writes, then reads. For every rule, what is not a read is a write.
enum class JobClass : std::uint8_t { stop, write, read };

/// Neither a read nor a stop: a stop cancels it, no read is shared across it, and it makes owed
/// answers outdated. Holds for any class that may come between stops and reads.
[[nodiscard]] constexpr bool is_write(JobClass job_class) {
  return job_class != JobClass::stop && job_class != JobClass::read;
}

/// How a job ended. Job::was_on_wire says whether it may have had an effect.
enum class Ending : std::uint8_t {
  answered,     ///< every transaction has its response, or the last one's is an exception
  transmitted,  ///< its last transaction, a broadcast or a request that is not answered, has left
  no_answer,    ///< transmitted, but no valid answer came
  expired,      ///< its deadline passed before a (further) transmission
  mismatched,   ///< a check (must_hold) failed; nothing after it was transmitted
  closed,       ///< the line is not open
  offline,      ///< the device is offline, and this request may not probe it
  cancelled     ///< withdrawn, evicted, or the gateway is stopping
};

struct Job;

/// A frame that is on the wire for one or several jobs, or is about to be sent again. Jobs with the
/// same request at the same time share a transmission. One of them leads, and has it: its
/// transaction is transmitted. The others follow and get the same answer.
struct Transmission {
  boost::container::small_vector<Job*, 1> followers;
  unsigned tries = 0;  ///< transmissions of the leader's current transaction
  /// The transaction that is sent once more because the connection was closed before its answer.
  std::optional<std::size_t> cut;
  bool in_flight = false;   ///< it was transmitted, and has not ended
  bool is_probe = false;    ///< tests whether an offline device answers again
  bool is_one_try = false;  ///< a stop that is not repeated, because an earlier one was given up
  Duration hurried_by{0};   ///< its wait is shorter by this, as the device may not be there
  Instant waits_since;      ///< of a stop: accepted then, or repeated
  Instant first_at;         ///< the first time of the current transaction
  Instant last_at;          ///< the last time of any of its transactions
  std::uint64_t writes_before = 0;  ///< writes to its device that ended before it was sent
};

struct Job {
  boost::intrusive::list_member_hook<> queue_hook;
  boost::intrusive::set_member_hook<> deadline_hook;
  boost::intrusive::list_member_hook<> stop_hook;  ///< of the stop lane

  std::uint32_t number = 0;  ///< the gateway's number for the job
  std::uint32_t owner = 0;   ///< and for the request it belongs to
  FairnessKey source{};
  unsigned weight = 1;                  ///< turns of its source where others have one
  JobClass job_class = JobClass::read;  ///< set by Bus::submit(), unless it is a stop already
  std::uint64_t sequence = 0;           ///< the order of acceptance, set by Bus::submit()
  Instant deadline;                     ///< without meaning for stops
  boost::container::small_vector<Transaction, 1> transactions;
  std::size_t current = 0;  ///< the transaction whose turn it is
  Transmission sent;        ///< of the current transaction, if it leads
  Instant accepted_at;
  bool was_on_wire = false;  ///< something that its client asked for was transmitted
  bool abandoned = false;    ///< its client is gone: no further transmission
  bool overtaken = false;    ///< cancelled by a stop of its device: no further transmission
  bool accepted = false;     ///< the bus has it

  [[nodiscard]] bool is_stop() const { return job_class == JobClass::stop; }
  /// Is it in the queue? Stops never are.
  [[nodiscard]] bool is_waiting() const { return queue_hook.is_linked(); }
  /// May other jobs use its device at the same time? Only beside a single read: a write may change
  /// something, and several transactions must not be interrupted.
  [[nodiscard]] bool is_single_read() const {
    return transactions.size() == 1 && transactions.front().request.is_read();
  }
  /// A broadcast may have checks (must_hold) of single devices before it.
  [[nodiscard]] bool is_broadcast() const { return transactions.back().is_broadcast(); }
  [[nodiscard]] bool is_read() const {
    return std::ranges::all_of(transactions,
                               [](const Transaction& it) { return it.request.is_read(); });
  }
  [[nodiscard]] std::uint8_t address() const { return transactions.front().address; }
  [[nodiscard]] Transaction& transaction() { return transactions[current]; }
  [[nodiscard]] const Transaction& transaction() const { return transactions[current]; }
  /// Nobody wants it sent any more.
  [[nodiscard]] bool is_abandoned() const {
    return abandoned && std::ranges::all_of(sent.followers, &Job::abandoned);
  }
  /// It has a single transaction, which is to be repeated.
  [[nodiscard]] bool is_between_tries() const {
    return sent.tries > 0 && !sent.in_flight && transactions.size() == 1;
  }
  /// From then on nothing is sent for `job`, which is this one or follows it. If a part of it was
  /// done, it is finished after its deadline, but nothing is repeated. The forms of a broadcast are
  /// no parts, nor are checks (must_hold).
  [[nodiscard]] Instant ends_at(const Job& job) const {
    const auto is_part = [](const Transaction& it) { return it.must_hold == nullptr; };
    const bool is_begun = sent.tries == 0 && !is_broadcast() &&
                          std::ranges::any_of(std::span(transactions).first(current), is_part);
    return is_begun ? Instant::max() : job.deadline;
  }
};

}  // namespace mbgate::bus
