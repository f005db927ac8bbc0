// SPDX-License-Identifier: Apache-2.0
// One TCP connection: its read-ahead, the answers that are due, and when it may be read further. It
// neither parses nor routes; the gateway does.
#pragma once

#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <optional>

#include "gateway/client.hpp"
#include "gateway/clients/due_answers.hpp"
#include "gateway/clients/early_stops.hpp"
#include "gateway/clients/read_ahead.hpp"
#include "routing/access.hpp"

namespace mbgate::gateway {

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

  /// Are `pipeline` requests outstanding? No other is taken then.
  [[nodiscard]] bool is_full() const { return answers.outstanding() >= listener_->pipeline; }
  /// Is no request taken now, whatever has come? Stops still are.
  [[nodiscard]] bool is_held_up() const { return is_full() || held_until; }
  /// Its turn may have come (AddressLimits).
  void end_hold(Instant now);

  /// The arrival time of bytes that were just read. If they may have come since reading was paused,
  /// they count as having arrived at the beginning of the pause. `unread`: bytes that can still be
  /// read from the socket.
  Instant arrival_of(std::size_t bytes, std::size_t unread, Instant now);
  /// Nothing was read since then, and what comes next may have waited as long: without TLS no
  /// longer than since the socket was seen empty, or since a reload, during which the process ran.
  /// What waited already is older still.
  void stall(Instant since);
  /// Where in the client's stream the next request begins.
  [[nodiscard]] std::uint64_t position() const { return position_; }
  /// The request at the front of `input` was handled: removes it.
  void pass(std::size_t bytes) {
    position_ += bytes;
    input.consume(bytes);
    partial_since.reset();
  }
  /// Is the request that begins there older than this process?
  [[nodiscard]] bool is_before_ready(std::uint64_t position) const {
    return position < info_.bytes_before_ready;
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
    return half_closed_ && pauses_.empty() && answers.outstanding() == 0 && !held_until;
  }
  /// Nothing that it has asked for is left to do.
  [[nodiscard]] bool is_at_rest() const {
    return answers.outstanding() == 0 && !held_until && !has_turn;
  }

  /// Which timeout of the client has passed.
  enum class Overdue : std::uint8_t { nothing, idle, within_request };
  [[nodiscard]] Overdue overdue(Instant now) const;
  /// When a timeout may pass next.
  [[nodiscard]] std::optional<Instant> next_look(Instant now) const;
  /// Call it after requests were taken: notes whether an incomplete request is at the front of
  /// `input` while it could be taken.
  void note_partial(Instant now);

  ReadAhead input;
  EarlyStops ahead;
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
  /// Its address has sent too many requests: the next one is taken then.
  std::optional<Instant> held_until;
  bool has_turn = false;                  ///< the next request is within the rate of its address
  bool is_in_line = false;                ///< it has waited for that turn, or still does
  std::optional<Instant> timer_armed_at;  ///< its entry in ClientTimers
  const Turns* turns = nullptr;           ///< of its address, until it is closed
  boost::container::small_vector<std::uint32_t, 4> exchanges;

 private:
  /// What ends its timeouts may lie in the socket: they are judged when that has been read.
  [[nodiscard]] bool may_have_asked() const { return !pauses_.empty() && !paused_; }

  ClientId id_;
  ClientInfo info_;
  ClientKey key_;
  const ListenerSettings* listener_;
  routing::ClientRights rights_;
  std::uint64_t position_ = 0;
  bool paused_ = false;
  bool half_closed_ = false;
  /// From this position of the stream on, bytes came after a pause had begun.
  struct PauseMark {
    std::uint64_t position;
    Instant began;
  };
  boost::container::small_vector<PauseMark, 1> pauses_;  // until the socket was seen empty
  std::uint64_t read_position_ = 0;
  std::size_t unread_ = 0;  // in the socket, after the last reading
  Instant seen_empty_;      // when nothing lay there, or the connection was let in
};

}  // namespace mbgate::gateway
