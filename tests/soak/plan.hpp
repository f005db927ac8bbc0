// SPDX-License-Identifier: Apache-2.0
// One seed's plant: the gateway's settings, the doors through which clients reach devices, and how
// often what goes wrong.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "gateway/settings.hpp"
#include "soak/access.hpp"
#include "soak/from_world.hpp"

namespace mbgate::soak {

inline constexpr std::uint16_t kInputs = 100;    ///< input registers that a window shows
inline constexpr unsigned kAddresses = 0x10000;  ///< of a table
inline constexpr Duration kLeastFrameTimeout = std::chrono::seconds(1);

/// A unit of a listener, as its clients see it.
struct Door {
  std::size_t listener = 0;
  std::uint8_t unit = 0;
  std::optional<std::size_t> device;  ///< none: a broadcast
  std::vector<std::size_t> buses;
  bool routed = false;      ///< what the device's profile says is done
  bool windowed = false;    ///< only its windows can be reached
  bool shows_coils = true;  ///< one of them shows coils
  /// Client addresses of the first register and coil; inputs are shown as holding registers.
  unsigned holding_at = 0;
  unsigned input_at = 0;
  unsigned coils_at = 0;
  unsigned moves = 0;        ///< of its windows, by reloads
  bool names_order = false;  ///< of words: no value may be cut by a write
  bool swapped = false;      ///< the client sees the words of values the other way round
  bool read_only = false;
  Duration read_deadline{0};
  Duration write_deadline{0};
  bool replies = true;                 ///< broadcasts: the client gets an echo
  std::optional<std::size_t> route{};  ///< none: a transparent listener's
  bool in_range = false;               ///< of a route that leads to addresses, not to a device
  bool only_autonics = false;          ///< broadcasts: address 129 alone
  bool is_closed = false;              ///< broadcasts: its listener lets nobody
  bool absent = false;                 ///< it leads nowhere at present, or another one has its unit
};

/// How bytes come from a line to the kernel.
enum class AdapterKind : std::uint8_t {
  uart,     ///< as they come from the line
  ticking,  ///< every 16 ms, as adapters at USB do
  late      ///< each chunk up to kAdapterHolds late
};
inline constexpr Duration kAdapterHolds = std::chrono::milliseconds(20);
/// No timeout is shorter than what an adapter keeps: not even an echo would come in time.
inline constexpr Duration kShortestTimeout = std::chrono::milliseconds(25);

/// In thousandths, of answers unless it says otherwise.
struct FaultRates {
  unsigned late = 0;
  unsigned twice = 0;
  unsigned never = 0;
  unsigned garbage = 0;
  unsigned wrong_unit = 0;
  unsigned wrong_function = 0;
  unsigned bad_crc = 0;
  unsigned damaged = 0;      ///< bits flipped, bytes lost or doubled on the way to the gateway
  unsigned late_pieces = 0;  ///< of late ones: with pauses
  unsigned pieces = 0;
  bool are_quick = false;  ///< its drives answer within a millisecond
  unsigned stuck = 0;      ///< it pauses, goes on, and breaks off
  unsigned glitch = 0;     ///< bytes before it that are no part of it
  unsigned too_long = 0;
  unsigned too_short = 0;   ///< fewer data than were asked for
  unsigned wrong_echo = 0;  ///< a good frame: another address, value or quantity than was written
  unsigned babble = 0;
  unsigned exception = 0;
  unsigned refuses_stop = 0;  ///< of stops, by an exception
  unsigned early = 0;
  unsigned boots_answered = 0;   ///< of what makes a device boot: it answers first
  unsigned straddles = 0;        ///< of late ASCII answers: a request is sent within one
  unsigned other_length = 0;     ///< of ASCII answers: a damaged one of another length goes before
  unsigned request_damaged = 0;  ///< of requests
  unsigned swapped = 0;       ///< of lines that are opened: by an adapter that hears itself, or not
  unsigned echo_damaged = 0;  ///< of requests, as the following
  unsigned echo_lost = 0;
  unsigned echo_cut = 0;            ///< something of it is missing
  unsigned prompt = 0;              ///< carried out and answered before it has left
  unsigned unknown_identifier = 0;  ///< of TCP answers: one more of nobody's goes before
  unsigned other_unit = 0;          ///< of TCP answers
  unsigned closes_after = 0;        ///< of TCP answers: the server closes the connection then
  unsigned closes_at_once = 0;      ///< of TCP connections
  unsigned breaks_off = 0;          ///< within one: what has come of it is lost
  unsigned breaks_framing = 0;      ///< of answers of TCP servers: what follows is no MBAP header
  unsigned swallows = 0;            ///< of TCP connections: nothing ever comes from the server
  unsigned overload = 0;            ///< TCP: so many requests a server drops, and then it is late
  unsigned echo_flickers = 0;       ///< of requests on lines that have shown an echo: none comes
  Duration idle_close{0};           ///< TCP: it closes a connection that is idle for so long
  Duration noise_every{0};          ///< 0: never
  Duration foreign_every{0};
  Duration lost_every{0};
  Duration dead_every{0};
  Duration babbles_every{0};  ///< a line is never silent, for seconds
  Duration hangs_every{0};    ///< nothing is heard from an adapter until it is opened again
  Duration sleeps{0};  ///< so long at most the plan's sleepers are silent at a time; 0: never
};

/// How a client behaves.
struct Manners {
  std::size_t listener = 0;
  unsigned host = 0;
  unsigned burst = 1;        ///< requests at once, at most
  unsigned outstanding = 1;  ///< it waits for answers beyond
  Duration pause{0};         ///< between bursts, at most
  Duration least_pause = std::chrono::microseconds(100);
  unsigned writes = 0;  ///< thousandths of its requests
  unsigned stops = 0;
  unsigned broadcasts = 0;
  unsigned malformed = 0;
  unsigned foreign = 0;
  unsigned splits = 0;
  unsigned stalls = 0;  ///< thousandths of its bursts, as the following
  unsigned vanishes = 0;
  unsigned half_closes = 0;
  std::uint16_t same_reads = 0;  ///< thousandths that ask for what everybody asks for
  bool same_stops = false;       ///< its stops of one drive are all alike
  std::uint16_t near_reads = 0;  ///< thousandths of its reads that are near those of others
  std::uint16_t alike = 0;       ///< thousandths of its reads and writes whose answers are alike
  Duration in_step{0};           ///< it asks whenever so much time has gone by, as others do
  Duration patience{0};          ///< it goes if there is no answer by then; 0: never
  unsigned hangs = 0;          ///< thousandths of its bursts, as the following: it stops within one
  unsigned loses_framing = 0;  ///< what it writes is no MBAP any more
  unsigned rests = 0;          ///< it asks for nothing any more
  bool waits_at_start = false;         ///< it has written before the gateway was ready
  bool never_asks = false;             ///< a probe: it connects, and goes again
  std::vector<std::size_t> devices{};  ///< that it asks; none: all
  unsigned asks_gateway = 0;  ///< thousandths of its requests, for what only the gateway answers
  unsigned watches = 0;  ///< thousandths of its requests, for what the gateway shows of devices
  routing::ClientRole role{};  ///< by its certificate
};

/// What the settings in force do not name, by its place in the plan; it comes back some time.
struct Absent {
  std::vector<bool> listeners;
  std::vector<bool> buses;
  std::vector<bool> devices;
  std::vector<bool> routes;
};

/// What only some drives have; whoever reads does not reach it.
struct Peculiarity {
  bool stops = false;  ///< kStopOfSome in kBroadcastRegister stops it
  bool value = false;  ///< at kValueOfSome
};

/// Wrong answers before what a device does is known: five as a rule, more where its times vary
/// much.
inline constexpr unsigned kMostAtAStart = 8;

/// What drives refuse stops with: not now, or not at all.
inline constexpr std::array<std::uint8_t, 8> kStopRefusals{1, 2, 3, 4, 5, 6, 0x0A, 0x0B};
/// After these a stop is repeated.
constexpr bool is_not_now(std::uint8_t code) {
  return code == 5 || code == 6 || code == 0x0A || code == 0x0B;
}

/// How a device works.
struct Ways {
  Duration service{0};      ///< it takes each request so long, one after the other; 0: at once
  unsigned second = 0;      ///< in thousandths, of answers: another one follows
  Duration second_from{0};  ///< so long behind the first one
  Duration second_to{0};
  unsigned most_wrong = kMostAtAStart;
};

/// What a part of the plans is arranged for.
enum class Theme : std::uint8_t {
  none,
  dead_drives,    ///< quiet lines on which some are silent for long, and asked and stopped all the
                  ///< same
  busy_line,      ///< nothing goes wrong, and whose turn it is decides everything
  shared_reads,   ///< all ask for the same, beside broadcasts, and the line is lost now and then
  late_drives,    ///< they are late again and again, for many minutes
  stops,          ///< drives are stopped while writes to them wait, which some let go first
  omissions,      ///< drives are quick, and leave out an answer now and then
  slow_drives,    ///< one works in order, and takes longer than its response timeout
  second_answers  ///< one answers twice
};

/// Nobody asks for anything, and nothing happens.
struct Calm {
  [[nodiscard]] Duration left(Instant now) const {
    return now >= from && now < until ? until - now : Duration{0};
  }
  Instant from = Instant::max();
  Instant until = Instant::max();
};

struct SoakPlan {
  std::uint64_t seed = 0;
  Theme theme = Theme::none;
  gateway::Settings settings;  ///< in force, in the plan's own order
  Absent absent;
  std::vector<Door> doors;
  std::vector<FaultRates> rates;               ///< by bus
  std::vector<AdapterKind> adapters;           ///< by bus
  std::vector<bus::LineKind> kinds;            ///< by bus, what its line is opened as
  std::vector<bool> echoes;                    ///< by bus: its line really hears itself
  std::vector<drive::WordOrder> own_orders;    ///< by device: what the drive itself is set to
  std::vector<bool> sleepers;                  ///< by device: it is silent for long now and then
  std::vector<Ways> ways;                      ///< by device
  std::vector<Peculiarity> peculiar;           ///< by device
  std::vector<std::vector<unsigned>> writers;  ///< by device, the hosts that its guard lists
  std::vector<std::vector<std::vector<std::uint8_t>>> failsafe;  ///< by device, the PDUs
  std::vector<SpokenRule> rules;
  std::vector<Manners> clients;
  DriverManners driver;
  Duration restarts_every{0};  ///< of the process; 0: never
  Calm calm;
  /// Silence of the clients is a reason for failsafe writes. It counts from when a request was
  /// taken, and nobody outside knows when that was of stops that were read ahead, and behind
  /// broadcasts without an answer: nobody sends any in these plants, and their driver is punctual.
  bool silence = false;
  std::vector<std::vector<unsigned>> readers;  ///< by listener, the hosts that may not write there
  std::vector<std::vector<unsigned>> kept;     ///< by listener, those that make room for nobody
  std::vector<std::vector<unsigned>> allowed;  ///< by listener, those that it lets in; none: all
  std::vector<Instant> idle_from;              ///< by listener, when its idle timeout was set
  bool limits_hosts = false;                   ///< each may connect and ask only so often
  bool moves_windows = false;  ///< reloads move the windows of its routes again and again
  bool stops_early = false;    ///< the gateway is told to stop in the midst of everything
  bool beyond = false;  ///< devices are later than the quarantine: misdeliveries are counted apart
};

SoakPlan draw_plan(Random& random, std::uint64_t seed);
/// What is behind the serial lines, and what the settings say of it.
void draw_lines(SoakPlan& plan, std::uint64_t seed);
void draw_line_kind(SoakPlan& plan, std::size_t bus, Random& random);
/// Nothing that began before a request has left answers it.
bool is_paced(const SoakPlan& plan, std::size_t bus);
/// Does everybody on the bus listen there, or every AiC?
bool is_for_all(const SoakPlan& plan, std::size_t bus, std::uint8_t address);
/// Listeners, routes and the doors that they make.
void draw_doors(SoakPlan& plan, Random& random);
/// The default deadlines, or those of its route.
void set_deadlines(const SoakPlan& plan, Door& door);
/// The windows of a route as its door knows them.
void set_windows(routing::Route& route, const Door& door);
/// The unit of a door as it would lead to another device, which a reload may bring about.
void add_twin(SoakPlan& plan, Door door, std::size_t device);
/// What is written to a device when nobody is left, and after how long a silence.
void draw_failsafe(SoakPlan& plan, std::size_t device, Random& random);
/// Whose turn is worth more than one.
void draw_weights(SoakPlan& plan, Random& random);
/// What its devices' guards allow.
void draw_guards(SoakPlan& plan, Random& random);
/// How many may connect to listeners, how long they may be silent, and who may only read.
void draw_limits(SoakPlan& plan, std::uint64_t seed);
/// What few plants have.
void draw_forms(SoakPlan& plan, std::uint64_t seed);
/// Of which drives nobody knows the word order.
void draw_orders(SoakPlan& plan, std::uint64_t seed);
/// Who often speaks to all, and which drives take what is said for a stop or a value.
void draw_broadcasts(SoakPlan& plan, std::uint64_t seed);
/// Who may speak to all, and silence devices; what a stop may be followed by.
void draw_odds(SoakPlan& plan, std::uint64_t seed);
/// How late answers come, and what breaks off.
void draw_late(SoakPlan& plan, std::uint64_t seed);
/// How often the process is killed and started again.
void draw_restarts(SoakPlan& plan, std::uint64_t seed);
/// Which drives work slowly or answer twice.
void draw_ways(SoakPlan& plan, std::uint64_t seed);
/// What goes wrong on few lines only.
void draw_rare_faults(SoakPlan& plan, std::uint64_t seed);
/// Reads that meet each other, and for how long they are kept.
void draw_reads(SoakPlan& plan, std::uint64_t seed);
/// Its last step but for lines and limits: who asks, and how.
void draw_clients(SoakPlan& plan, Random& random);
/// Routes of one listener, which go before those of all for the same units.
void draw_own_routes(SoakPlan& plan, std::uint64_t seed);
/// Has a route of its listener's own taken its unit?
[[nodiscard]] bool is_hidden(const SoakPlan& plan, const Door& door);
/// How often one host may connect and ask, where that is limited; and who does so more often.
void draw_client_rates(SoakPlan& plan, std::uint64_t seed);
void draw_client_limits(gateway::ListenerSettings& listener, Random& random);
/// Roles in certificates where no rule names any; some cannot be read.
void draw_roles_alone(SoakPlan& plan, std::uint64_t seed);
/// Windows that reloads move while much waits behind full pipelines.
void draw_windows(SoakPlan& plan, std::uint64_t seed);
/// Arranges some plans so that what seldom happens happens often.
void draw_theme(SoakPlan& plan, std::uint64_t seed);

}  // namespace mbgate::soak
