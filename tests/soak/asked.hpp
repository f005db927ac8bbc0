// SPDX-License-Identifier: Apache-2.0
// A request as the oracle knows it: what must go over the wire for it, and what its answer may be.
// Nothing here comes from the product but the bytes of the client's own request.
#pragma once

#include <bitset>
#include <cstdint>
#include <optional>
#include <vector>

#include "gateway/client.hpp"
#include "modbus/request.hpp"
#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {

using gateway::ClientId;
using PduBytes = std::vector<std::uint8_t>;

/// One transaction of a request as it must look on the wire.
struct Piece {
  std::size_t bus = 0;
  std::uint8_t address = 0;
  PduBytes pdu;
  unsigned sent = 0;                ///< transmissions that were surely or perhaps for this piece
  bool executed = false;            ///< the device has carried it out
  bool counted = false;             ///< among those that wait for their bus
  std::optional<Instant> doomed{};  ///< of a broadcast: a stop has taken it back
  Span done{};                      ///< when it was carried out, the first and the last time
  bool answered = false;            ///< an answer came that the gateway may have taken
  bool taken_back = false;  ///< other settings give it another meaning: nothing more of it is sent
  bool asks_order = false;  ///< it reads the drive's word order before values are written
};

/// What an answer must show.
struct ReadCheck {
  modbus::Table table = modbus::Table::holding_registers;
  std::uint16_t first = 0;  ///< of the device
  std::uint16_t count = 0;
  bool swapped = false;
};

enum class Kind : std::uint8_t { read, write, stop, broadcast, own };

struct Asked {
  std::uint64_t id = 0;
  ClientId client{};
  unsigned host = 0;  ///< of its client
  routing::ClientRole role{};
  std::uint16_t transaction = 0;
  Kind kind = Kind::read;
  const Door* door = nullptr;
  std::uint8_t unit = 0;
  PduBytes pdu;  ///< of the client
  std::vector<Piece> pieces;
  std::optional<std::uint8_t> refused;  ///< the gateway itself must answer this exception
  std::optional<ReadCheck> check;
  bool stops_all = false;     ///< a broadcast that is a stop
  bool for_some = false;      ///< of these: it stops only the drives that know it
  bool identity = false;      ///< it asks the device who it is
  bool is_shared = false;     ///< a stop that is like others
  bool is_repeated = false;   ///< a stop of the drive's, which is repeated without a fitting echo
  bool has_no_table = false;  ///< its answer repeats all of it
  bool other_order = false;   ///< the drive turns out to have another word order: 04, not written
  bool any_code = false;      ///< of the status unit: it may be refused
  bool unlisted = false;      ///< by the device's `writer`; it may also be taken back by a stop
  bool replies = true;
  bool silent = false;  ///< the device never answers it; the gateway does

  Instant written;   ///< the gateway could know of its first byte
  Instant earliest;  ///< as old as the gateway may take it to be
  Instant accepted;  ///< as early as can be
  Instant deadline = Instant::max();
  std::uint64_t sequence = 0;  ///< of acceptance
  /// Another one of the same client address, to the same device or to all, was to go before it.
  Instant waited_until = Instant::min();
  bool has_begun = false;       ///< its first byte was read
  bool waits_in_pause = false;  ///< it lay in the socket while the gateway did not read
  bool is_accepted = false;
  bool ordered = false;        ///< its answer may be held back for those before it
  bool ahead = false;          ///< it may have been accepted later
  bool perhaps_older = false;  ///< a stop: than what its unit has come to mean
  bool perhaps_later = false;  ///< a stop: than it is accepted here, for want of room or held
  bool perhaps_held = false;   ///< a stop: by writes before it, if they are not outdated
  bool client_gone = false;
  bool dropped = false;               ///< a waiting write of a half-closed connection
  bool found_no_room = false;         ///< a stop that came when there was room for no more
  std::optional<Instant> doomed;      ///< a stop has taken it back
  std::optional<Instant> waits_from;  ///< a stop that waits: nothing may be older than this
  PduBytes last_sent;                 ///< as it looked on the wire
  std::uint64_t last_alone = 0;       ///< its last flight, if that was surely for it; else 0
  unsigned flights = 0;               ///< that it was among
  unsigned flights_alone = 0;         ///< that were surely for it
  std::uint64_t last_flight = 0;      ///< that it was among last
  std::vector<std::uint64_t> tries;   ///< the flights that it was among
  unsigned merged_tries = 0;          ///< of these, surely, as a part of a longer read
  bool was_stopped = false;           ///< by the same one before, when its answer came
  bool echoed = false;                ///< what looks like its answer was its echo
  bool hurried = false;               ///< its answer began before it had left a paced line
  unsigned spoilt = 0;                ///< of these, heard differently than they were sent
  std::optional<Instant> cut;         ///< its server has closed the connection meanwhile
  bool maybe_on_wire = false;
  bool surely_on_wire = false;
  std::bitset<256> device_exceptions;  ///< given to transmissions that may be its own
  const char* uncertain = nullptr;     ///< why nobody can tell whose answer it got
  bool overdue_reported = false;
  /// The most that any settings allowed since it was accepted.
  unsigned retries = 0;
  unsigned stop_retries = 0;
  bool retry_writes = false;
  Duration cache{0};
  std::optional<drive::WordOrder> word_order;  ///< that its route asked for
  std::vector<std::size_t> rated;              ///< rules with a rate that permit it
  // Of hosts that may ask so often only:
  std::optional<Instant> begun;       ///< the gateway has read its first byte
  std::optional<Instant> held_until;  ///< at the latest, if nothing else held it up
  std::uint64_t held_in_order = 0;    ///< that is known only as long as this is so
  bool passes_hold = false;           ///< a stop behind it waits for it

  /// One device is stopped, or all on its buses.
  [[nodiscard]] bool is_stop() const { return kind == Kind::stop || stops_all; }
  [[nodiscard]] bool is_read() const { return kind == Kind::read; }
  [[nodiscard]] bool changes() const { return kind != Kind::read && kind != Kind::own; }
};

/// The gateway has read its beginning before.
inline bool has_come_before(const Asked& asked, Instant at) {
  return asked.has_begun && asked.written < at;
}

/// Several parts of a request may go to one bus: it waits there as one.
inline bool is_first_on_its_bus(const Asked& asked, const Piece& piece) {
  return &piece == &asked.pieces.front() || piece.bus != (&piece - 1)->bus;
}

}  // namespace mbgate::soak
