// SPDX-License-Identifier: Apache-2.0
// A plant, drawn from a seed: the gateway's settings, what really is behind its lines, who asks,
// and what goes wrong. Each fault is a figure here, so that a plant can be told to have it or not.
#pragma once

#include <bitset>

#include "gateway/settings.hpp"
#include "world/driver.hpp"
#include "world/hosts.hpp"
#include "world/registers.hpp"

namespace mbgate::world {

/// How a drive behaves. Chances in thousandths of answers, unless it says otherwise.
struct Habits {
  Duration quick{0};       ///< it answers within so long
  Duration service{0};     ///< it takes each request so long, one after the other; 0: at once
  unsigned late = 0;       ///< after its timeout, within the quarantine
  unsigned very_late = 0;  ///< beyond
  unsigned never = 0;
  unsigned second = 0;  ///< another answer follows
  Duration second_from{0};
  Duration second_to{0};
  unsigned copies = 0;  ///< the answer is said twice, without a pause
  unsigned damaged = 0;
  bool damages_check = false;  ///< and nothing else of the answer
  unsigned cut = 0;            ///< the rest never comes
  unsigned crawls = 0;         ///< one byte, a long pause, and the next
  unsigned pauses = 0;         ///< within an answer, for less than `frame_slack`
  unsigned long_pauses = 0;    ///< for more
  unsigned misfits = 0;   ///< other lengths, functions, addresses and values, with a good check
  unsigned glitches = 0;  ///< bytes in front
  std::size_t most_glitches = 8;  ///< so many of them
  unsigned tails = 0;             ///< a byte or more behind
  unsigned exceptions = 0;
  unsigned limits = 0;         ///< of writes: another value is taken, and echoed
  unsigned refuses_stops = 0;  ///< of stops: an exception that asks for another try
  unsigned deaf = 0;           ///< of requests
  bool dead = false;           ///< it has no supply
  Duration sleeps_every{0};    ///< it is without supply for `sleeps_for` at most; 0: never
  Duration sleeps_for{0};
  bool freezes = false;  ///< with its supply: afterwards it answers what it was asked meanwhile
};

/// A drive at a place.
struct DrivePlan {
  Habits habits;
  drive::WordOrder order = drive::WordOrder::big;
};

/// An address on a bus, as the gateway knows it: mostly one drive.
struct Station {
  std::size_t bus = 0;
  std::uint8_t address = 0;
  std::optional<std::size_t> device{};  ///< of the settings; none: a route leads to the address
  std::vector<std::size_t> drives{};
  bool every_unit = false;        ///< of a TCP server: whatever the unit
  bool other_broadcasts = false;  ///< it hears them in the form of AiC
};

/// How bytes come from a line to the kernel.
enum class AdapterKind : std::uint8_t {
  uart,     ///< as they come from the line
  ticking,  ///< every 16 ms, as adapters at USB do
  late      ///< each chunk up to 20 ms late
};

/// What is behind a line, and how often what goes wrong; 0: never.
struct LinePlan {
  AdapterKind adapter = AdapterKind::uart;
  bus::LineKind kind = bus::LineKind::virtual_line;
  bool echoes = false;
  Duration noise_every{0};
  Duration stranger_every{0};  ///< another client asks a drive of its own
  Duration lost_every{0};
  Duration hangs_every{0};   ///< nothing is heard until it is opened again
  Duration stalls_every{0};  ///< it keeps what is sent, and sends it when it goes on
  bool tells_unsent = true;  ///< the driver says what it still holds
  // Of a Modbus TCP server, in thousandths of answers:
  bool keeps_identifiers = true;  ///< or each answer has the identifier 0
  unsigned other_identifier = 0;
  unsigned other_unit = 0;
  unsigned wrong_length = 0;
  unsigned half = 0;  ///< of an answer, and then nothing more on this connection
  unsigned closes_after = 0;
  unsigned stray = 0;  ///< an answer with an identifier of nobody goes before
  Duration idle_close{0};
};

/// A unit of a listener, as its clients see it.
struct Door {
  std::size_t listener = 0;
  std::uint8_t unit = 0;
  std::optional<std::size_t> station{};  ///< none: a broadcast
  std::vector<std::size_t> buses{};      ///< of a broadcast
  std::optional<std::size_t> route{};    ///< none: a transparent listener
  bool routed = false;                   ///< to a [[device]]: what its profile says is done
  bool windowed = false;
  unsigned holding_at = 0;  ///< client address of the first register
  unsigned input_at = 0;    ///< of input registers, shown as holding registers
  bool swapped = false;
  bool read_only = false;
  std::optional<std::bitset<128>> functions{};  ///< that its route names
  bool replies = true;
  Duration read_deadline{0};
  Duration write_deadline{0};
};

/// An access rule, by hosts and stations. What is empty fits everything.
struct RulePlan {
  bool permits = true;
  bool reads = true;   ///< it is about requests that read,
  bool writes = true;  ///< or about those that write
  std::vector<unsigned> hosts{};
  std::vector<std::size_t> listeners{};
  std::vector<std::size_t> stations{};
  std::vector<std::uint8_t> units{};
  std::vector<std::uint8_t> functions{};
  std::vector<Range> spans{};  ///< of the drive
  bool stops = false;          ///< and writes that stop
  bool communication = false;  ///< and its communication register
  unsigned rate = 0;           ///< a second and host that it permits; 0: any number
};

/// How a client behaves. Chances in thousandths of its requests or bursts.
struct Manners {
  std::size_t listener = 0;
  unsigned host = 0;
  unsigned burst = 1;
  unsigned outstanding = 1;
  Duration pause{0};
  unsigned writes = 0;
  unsigned stops = 0;
  unsigned broadcasts = 0;
  unsigned malformed = 0;
  unsigned same_reads = 0;
  unsigned splits = 0;
  unsigned foreign = 0;  ///< ADUs of another protocol
  unsigned vanishes = 0;
  unsigned half_closes = 0;
  unsigned stalls = 0;   ///< it reads no answers for a while
  Duration patience{0};  ///< it asks again, or goes, after so long without an answer; 0: never
  bool repeats = false;
  bool plain = false;  ///< it reads four registers, writes one, and stops; nothing else
  std::vector<std::size_t> stations{};  ///< that it asks; empty: all
};

struct Plan {
  std::uint64_t seed = 0;
  gateway::Settings settings;
  std::vector<Station> stations;
  std::vector<DrivePlan> drives;
  std::vector<LinePlan> lines;
  std::vector<Door> doors;
  std::vector<std::vector<unsigned>> readers;  ///< by listener: hosts that may not write
  std::vector<RulePlan> rules;
  std::vector<std::vector<unsigned>> writers;  ///< by device, of those that list theirs: hosts
  unsigned takes_rights = 0;                   ///< so often a reload takes rights away
  std::vector<Manners> clients;
  DriverManners driver;
  Duration restarts_every{0};  ///< the process is killed
  Duration reloads_every{0};
  bool meanings_change = false;  ///< reloads also change what requests mean
  bool default_times = false;

  [[nodiscard]] const gateway::BusSettings& bus(std::size_t at) const { return settings.buses[at]; }
  [[nodiscard]] bool is_tcp(std::size_t at) const {
    return bus(at).line.framing == bus::Framing::tcp;
  }
  /// Can answers be told apart by an identifier?
  [[nodiscard]] bool has_identifiers(std::size_t at) const {
    return is_tcp(at) && lines[at].keeps_identifiers;
  }
  [[nodiscard]] const drive::Device* device_of(const Station& station) const {
    return station.device ? &settings.devices[*station.device] : nullptr;
  }
  [[nodiscard]] bool has_failsafe(const Station& station) const {
    return station.device && !settings.guards[*station.device].failsafe.empty();
  }
  /// The times of the station, as they are configured.
  [[nodiscard]] const drive::DeviceTiming& timing_of(const Station& station) const {
    return station.device ? settings.devices[*station.device].timing
                          : settings.buses[station.bus].timing;
  }
};

Plan draw_plan(std::uint64_t seed);
/// What a reload may change, drawn anew.
void draw_timing(drive::DeviceTiming& timing, bool is_default, Random& random);
/// From the routes' and devices' own times, as the contract has it.
void set_deadlines(Plan& plan);

// The parts that a plan is drawn in.
/// What the settings say of a drive that has the registers of world/registers.hpp.
void draw_profile(drive::Device& device, bool is_tcp, Random& random);
/// Listeners, routes, and the doors that they make.
void draw_doors(Plan& plan, Random& random);
/// Who may write to a device, and what is written when everybody has gone.
void draw_guards(Plan& plan, Random& random);
void draw_clients(Plan& plan, Random& random);

}  // namespace mbgate::world
