// SPDX-License-Identifier: Apache-2.0
// What happened in the world, as a chronicle and nothing else: what clients asked and got, what the
// gateway put on its lines, what drives carried out, and what reached the kernel. It knows no rule
// of the gateway's; the truths (judge/) are asked over it.
#pragma once

#include <deque>
#include <optional>
#include <unordered_map>
#include <vector>

#include "world/registers.hpp"

namespace mbgate::world {

using Id = std::uint32_t;
inline constexpr Id kNone = ~Id{0};
inline constexpr Instant kNever = Instant::max();

enum class Kind : std::uint8_t { read, write, stop, broadcast, own };

/// One register or coil, or what else a request says, and what is written there. Every write has
/// words of its own, so that on the wire it can be told from all others.
struct Cell {
  Table table = Table::holding_registers;
  unsigned place = 0;
  std::uint32_t word = 0;
  friend bool operator==(const Cell&, const Cell&) = default;
};
/// Beyond the registers of a table: masks of function 22 (the word holds both), and the data of
/// functions that name no register.
inline constexpr unsigned kMasks = 1U << 20U;
inline constexpr unsigned kOpaque = 1U << 21U;

/// What a request means to its drive, worked out when it was made.
struct Intent {
  Kind kind = Kind::read;
  std::size_t door = 0;
  std::uint8_t unit = 0;
  Octets pdu;                            ///< the client's
  std::optional<std::size_t> station{};  ///< none: a broadcast, or nobody's
  std::vector<std::size_t> buses{};      ///< of a broadcast
  std::optional<Range> reads{};          ///< of the drive
  bool swapped = false;                  ///< the client sees the words of values in another order
  bool whole = false;                    ///< it goes on the wire as it is: `sent`
  Octets sent{};
  std::vector<Cell> writes{};
  bool refused = false;              ///< the gateway must answer one of `codes` and send nothing
  std::uint16_t codes = 0;           ///< exceptions that the gateway may refuse it with, each a bit
  bool denied = false;               ///< for want of a right, and else it could be done
  std::vector<std::size_t> rated{};  ///< rules that count it for their rates
  bool answer_due = true;            ///< or the client expects none: a broadcast
  bool silent = false;               ///< the drive never answers it, the gateway does
  bool is_odd_read = false;  ///< a read that names no register: its answer is the drive's own
};

constexpr std::uint16_t code(unsigned exception) {
  return static_cast<std::uint16_t>(1U << exception);
}

/// A connection of a client to the gateway.
struct Connection {
  std::size_t listener = 0;
  unsigned host = 0;
  unsigned process = 0;
  Instant opened{};
  Instant gone = kNever;         ///< the gateway was told, or has closed it itself
  Instant half_closed = kNever;  ///< likewise
};

/// A request of a client.
struct Asked {
  Id connection = kNone;
  std::uint16_t transaction = 0;
  Intent intent;
  Instant written{};          ///< its last byte, by the client
  Instant given = kNever;     ///< the gateway has all of it
  Instant answered = kNever;  ///< the first time
  Octets answer{};
  unsigned answers = 0;
  bool dropped = false;           ///< its connection has gone
  bool given_up = false;          ///< its client does not wait any more
  bool outdated = false;          ///< a reload gave its unit another meaning meanwhile
  bool perhaps_outdated = false;  ///< the same before the gateway had it
  bool withdrawn = false;         ///< a reload has taken the right to it, before it went anywhere
  std::vector<Id> sent{};         ///< transmissions that carried a part of it
};

/// A frame that the gateway has put on a line.
struct Sent {
  std::size_t bus = 0;
  unsigned process = 0;
  unsigned opening = 0;
  std::uint8_t address = 0;
  std::uint16_t identifier = 0;
  Octets pdu{};
  bool readable = false;
  std::optional<std::size_t> station{};
  bool is_broadcast = false;
  bool has_other_form = false;  ///< at address 129, its function with 0x80 (AiC, section 2.13)
  std::vector<Id> asked{};      ///< whose it may be
  std::vector<Cell> cells{};
  std::optional<Range> reads{};
  bool is_stop = false;
  bool is_failsafe = false;
  bool expects_answer = true;
  Instant begin{};
  Instant end{};  ///< computed: when its last bit leaves
  // What came of it, in the world:
  Instant left = kNever;         ///< its last bit has really left
  Instant heard = kNever;        ///< likewise, and nothing came before
  Instant answered = kNever;     ///< a whole fitting answer has reached the kernel
  std::uint32_t exceptions = 0;  ///< that drives answered, each code a bit
  bool limited = false;          ///< the drive has taken another value
  Instant crawls = kNever;       ///< since then its answer comes, a byte and a long pause at a time
};

/// What a drive has carried out.
struct Done {
  Id sent = kNone;
  Instant at{};
};

/// Bytes that reached the kernel.
struct Came {
  Instant at{};
  Instant said{};          ///< the last bit on the line; earlier where an adapter kept them
  Id answers = kNone;      ///< the transmission whose answer ends here
  bool fits = false;       ///< it is what was asked for
  bool is_second = false;  ///< it was said before
  bool ends_wait = false;  ///< it does not fit, and is the drive's: a misfit, or a bad CRC
  bool was_held = false;   ///< by a device server, until somebody connected
  std::size_t bytes = 0;
};

/// A line as the gateway knows it.
struct LineBook {
  bool open = false;
  unsigned openings = 0;
  Instant opened{};
  Instant closed = Instant::min();
  std::deque<Came> came{};         ///< of the last seconds
  Instant heard = Instant::min();  ///< the last byte reached the kernel
  Instant said = Instant::min();   ///< its last bit on the line
  Id last = kNone;                 ///< transmission
  Id halved = kNone;  ///< transmission: a part of its answer came, and nothing comes behind it
  Instant halved_at{};
};

struct Ledger {
  std::vector<Connection> connections;
  std::deque<Asked> asked;
  std::deque<Sent> sent;
  std::deque<Done> done;
  std::vector<LineBook> lines;
  std::vector<std::vector<Id>> open_reads;       ///< by station: given, not answered
  std::vector<std::vector<Id>> last_sent;        ///< by station: the last transmissions to it
  std::vector<std::vector<Id>> stops;            ///< by station: given
  std::unordered_map<std::uint64_t, Id> writer;  ///< by key_of(): who writes it
  std::unordered_map<std::uint64_t, std::vector<Id>> carriers;  ///< likewise: its transmissions
  std::unordered_map<std::uint64_t, std::vector<Id>> doers;     ///< likewise: who carried it out
  unsigned process = 0;
  Instant started{};  ///< the process
  Instant reloaded = Instant::min();
  Instant stopping = kNever;
  bool calm = false;        ///< faults have stopped
  Instant rested = kNever;  ///< a minute later, when all clients go
};

/// In place of a station: all drives of a bus, for broadcasts.
constexpr std::size_t all_of(std::size_t bus) { return 0x80U + bus; }
/// Of a cell of a station. There are fewer than 128 stations.
constexpr std::uint64_t key_of(std::size_t station, const Cell& cell) {
  return std::uint64_t{station} << 56U | static_cast<std::uint64_t>(cell.table) << 54U |
         std::uint64_t{cell.place} << 32U | cell.word;
}

/// A value that stops a drive of the world.
bool is_stopping(const Cell& cell);
/// What a request on a line writes; of functions that name no table, their data. Empty for those
/// that write nothing or cannot be read.
std::vector<Cell> cells_of(Bytes pdu);
/// 1 to 4, 7, 11, 12, 17, 20, 24 and 43/14.
bool is_read(Bytes pdu);

}  // namespace mbgate::world
