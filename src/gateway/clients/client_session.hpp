// SPDX-License-Identifier: Apache-2.0
// One TCP connection: the bytes that are not a request yet, the answers that are due, and whether
// the socket may be read. It neither parses nor routes; the gateway does.
#pragma once

#include <boost/container/small_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "bus/instant.hpp"
#include "gateway/client.hpp"
#include "gateway/limits.hpp"
#include "modbus/bytes.hpp"
#include "modbus/mbap.hpp"
#include "routing/route.hpp"

namespace mbgate::gateway {

// The answers that a client is still to get: their number, and the ones that wait for earlier
// answers (`ordered`).

class DueAnswers {
 public:
  struct Answer {
    modbus::MbapBytes adu;
    bus::Instant until = bus::Instant::max();  ///< then its client has given up
    bool is_stops = false;
  };
  using Ready = boost::container::small_vector<modbus::MbapBytes, 1>;

  explicit DueAnswers(bool ordered) : ordered_(ordered) {}

  /// Requests whose answer is due.
  [[nodiscard]] std::size_t unanswered() const { return open_ + held_.size(); }
  /// And those whose answer has not been completely written.
  [[nodiscard]] std::size_t outstanding() const { return unanswered() + unsent_; }

  /// A request was taken: its answer is due.
  AnswerId open();
  /// Without an answer: there will be none. Returns the ADUs that are to be sent now: with
  /// `ordered = true` an answer waits for those before it.
  Ready close(AnswerId id, const std::optional<Answer>& answer, bus::Instant now);
  /// The client does not want the answers any more that wait for those before them. Those to stops
  /// stay.
  void drop_waiting();
  /// An answer has been completely written.
  void confirm_sent() { unsent_ -= unsent_ > 0 ? 1 : 0; }

 private:
  struct Held {
    bool done = false;
    std::optional<Answer> answer;
  };

  bool ordered_;
  std::size_t open_ = 0;    // unordered: answers that are due
  std::size_t unsent_ = 0;  // answers on their way to the socket
  std::deque<Held> held_;   // ordered: answers due or waiting, oldest first
  std::uint64_t first_held_ = 0;
};

// Bytes of a client that have not become requests yet: an incomplete request, or requests beyond
// the number that a connection may have.

class ClientInput {
 public:
  /// `arrival`: when they arrived in the socket, or earlier.
  void append(modbus::Bytes bytes, bus::Instant arrival, bus::Instant now) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(consumed_));
    consumed_ = 0;
    first_ = bytes_.empty() ? arrival : first_;
    last_ = arrival;
    read_at_ = now;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void consume(std::size_t bytes) {
    consumed_ += bytes;
    first_ = last_;
  }
  [[nodiscard]] bool empty() const { return bytes().empty(); }
  [[nodiscard]] modbus::Bytes bytes() const { return modbus::Bytes(bytes_).subspan(consumed_); }
  /// Of the first byte.
  [[nodiscard]] bus::Instant arrival() const { return first_; }
  /// When the last of them were read.
  [[nodiscard]] bus::Instant read_at() const { return read_at_; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t consumed_ = 0;  // of these
  bus::Instant first_;
  bus::Instant last_;
  bus::Instant read_at_;
};

class ClientSession {
 public:
  ClientSession(ClientId id, const ClientInfo& info, const ListenerSettings& listener, Instant now);

  [[nodiscard]] ClientId id() const { return id_; }
  [[nodiscard]] const ClientInfo& info() const { return info_; }
  /// For the whole connection.
  [[nodiscard]] const ClientKey& key() const { return key_; }
  [[nodiscard]] const ListenerSettings& listener() const { return *listener_; }
  [[nodiscard]] routing::ClientRights rights() const { return rights_; }
  /// New settings of the listener.
  void adopt(const ListenerSettings& listener);

  /// Are as many requests unanswered as a connection may have? No other is taken then.
  [[nodiscard]] bool is_full() const { return answers.unanswered() >= kRequestsOutstanding; }
  /// May a request go on to the buses?
  [[nodiscard]] bool has_room_on_buses() const {
    return exchanges.size() - held.size() < listener_->pipeline;
  }

  /// The arrival time of bytes that were just read: when the socket was last seen empty before, or
  /// now, if it was never seen otherwise. `unread`: bytes that can still be read from the socket.
  Instant arrival_of(std::size_t unread, Instant now);
  /// Nothing was read since then, and what comes next may have waited as long: without TLS no
  /// longer than since the socket was seen empty, or since a reload, during which the process ran.
  /// What waited already is older still.
  void stall(Instant since);
  /// New settings are in force: the process did not stand still then.
  void note_reload(Instant now) { ran_at_ = now; }
  /// The request at the front of `input` was handled: removes it.
  void pass(std::size_t bytes) {
    input.consume(bytes);
    partial_since.reset();
  }

  /// Call it after bytes or answers came. Returns whether reading must be paused or may be resumed;
  /// nothing: no change.
  enum class Reading : std::uint8_t { pause, resume };
  std::optional<Reading> update_reading(Instant now);

  /// The peer has sent FIN. While reading is paused, bytes before it may still be unread.
  void half_close();
  [[nodiscard]] bool is_half_closed() const { return half_closed_; }
  /// Half-closed, everything read, everything answered and sent.
  [[nodiscard]] bool is_finished() const {
    return half_closed_ && !waits_since_ && answers.outstanding() == 0;
  }
  /// Nothing that it has asked for is left to do.
  [[nodiscard]] bool is_at_rest() const { return answers.outstanding() == 0; }

  /// Which timeout of the client has passed.
  enum class Overdue : std::uint8_t { nothing, idle, within_request };
  [[nodiscard]] Overdue overdue(Instant now) const;
  /// When a timeout may pass next.
  [[nodiscard]] std::optional<Instant> next_look(Instant now) const;
  /// Call it after requests were taken: notes whether an incomplete request is at the front of
  /// `input` while it could be taken.
  void note_partial(Instant now);

  ClientInput input;
  DueAnswers answers;
  bool has_asked = false;  ///< it has sent a valid request
  bool is_closed = false;  ///< removed as soon as it is no longer in use
  bool is_leaving =
      false;  ///< it is disconnecting: only its stops are still taken, and it gets no answers
  bool speaks_rtu_reported = false;
  std::uint64_t requests = 0;  ///< requests and refusals are counted for displays only
  std::uint64_t refused = 0;   ///< answered with an exception of the gateway's own
  Instant last_activity;
  std::optional<Instant> partial_since;  ///< an incomplete ADU is at the front of `input`
  Instant timer_at = Instant::max();     ///< its timer in Sessions; max(): it has none
  const Turns* turns = nullptr;          ///< of its address, until it is closed
  boost::container::small_vector<std::uint32_t, 4> exchanges;
  /// Of these, those beyond `pipeline`, which no bus has yet.
  boost::container::small_vector<std::uint32_t, 4> held;

 private:
  /// What ends its timeouts may lie in the socket: they are judged when that has been read.
  [[nodiscard]] bool may_have_asked() const { return waits_since_ && !paused_; }

  ClientId id_;
  ClientInfo info_;
  ClientKey key_;
  const ListenerSettings* listener_;
  routing::ClientRights rights_;
  bool paused_ = false;
  bool half_closed_ = false;
  /// What lies in the socket may have waited there since then; nothing: the socket is empty.
  std::optional<Instant> waits_since_;
  /// The process ran then: it saw the socket empty, let the connection in, or took over settings.
  Instant ran_at_;
};

}  // namespace mbgate::gateway
