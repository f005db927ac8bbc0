// SPDX-License-Identifier: Apache-2.0
// The state of the whole gateway at one instant, as plain values with names in them: it can be read
// on another thread, and after a reload. Making it changes nothing.
//
// To change
// - the contents of the status: status_report; as JSON: app/control/status_json, docs/api.yaml; for
//   people: ctl/control/status_text, which cuts it to the window too; drawn in place:
//   ctl/control/status_command.
// - faults, and when they are found: report/findings.
// - the duration of requests: bus/durations; the state of a device, its beginning, and the
//   transmissions unanswered since it was heard: bus/health/device_health.
// - requests that wait for a line: bus/parts; its load, and other clients on it:
//   bus/health/line_diagnosis.
// - the registers of unit 255: gateway/status_unit, and the table in docs/status.md; another
//   layout: kLayoutVersion.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bus/bus.hpp"
#include "gateway/settings.hpp"
#include "gateway/status_unit.hpp"

namespace mbgate::gateway {

/// A client address with requests that wait for a line. Those that wait for their device, because
/// it owes an answer, boots or is offline, do not count.
struct WaitingClient {
  std::string address;
  std::size_t requests = 0;
  std::size_t of = 0;       ///< of all client addresses
  Duration longest{0};      ///< how long its first one has waited
  bool others_ask = false;  ///< clients of other addresses are connected, and have asked
};

struct BusStatus {
  std::string name;
  std::string line;  ///< the path of a serial line, or HOST:PORT
  bus::Framing framing = bus::Framing::rtu;
  bool is_serial = true;
  modbus::Baud baud{0};
  modbus::CharacterFormat format;
  Duration character{0};  ///< how long one takes; 0: a connection to a Modbus TCP server
  Duration frame_gap{0};  ///< the silence before each transmission; 0: as before
  bool is_open = false;
  bool is_starting = false;   ///< the first attempt to open it runs
  bool is_reopening = false;  ///< the gateway has closed it itself, because its adapter hung
  bus::LineState state = bus::LineState::initial;
  unsigned load = 0;     ///< percent of the time of the line
  bus::LineWaits waits;  ///< how many requests waited for it, in the time of the load
  Duration busy{0};      ///< the time of the line in all
  std::size_t waiting = 0;
  Duration longest_waiting{0};  ///< how long the request has waited that waits longest
  bus::Histogram silences{bus::kSilenceBounds};  ///< before transmissions
  Duration silence{0};                           ///< how long nothing at all was received
  bus::BusCounters counters;
  std::optional<WaitingClient> most_waiting;     ///< the one with the most of them
  std::optional<Duration> last_foreign;          ///< how long ago the last foreign frame came
  std::optional<Duration> last_foreign_request;  ///< the same, of those that are requests
  std::optional<Duration> last_never_silent;     ///< how long ago it had no silence for too long
  bus::NoticedEcho echo = bus::NoticedEcho::none;
  bus::QualityVerdict quality;
};

/// The word order that a drive is set to is not the configured one.
struct OtherWordOrder {
  std::uint16_t address;  ///< of the holding register that tells
  std::uint16_t holds;
  std::vector<std::uint16_t> expected;  ///< one of these
};

struct DeviceStatus {
  using State = bus::DeviceState;

  std::string name;     ///< empty: an address that the configuration has no device for
  std::size_t bus = 0;  ///< its place in StatusReport::buses
  std::uint8_t address = 0;
  State state = State::not_asked;
  std::optional<Duration>
      state_since;            ///< how long ago it began; not_asked, line_not_open: nothing
  bool has_answered = false;  ///< ever
  std::optional<Duration> last_request;  ///< how long ago one was sent to it
  std::optional<Duration> last_answer;   ///< how long ago that was
  unsigned unanswered_in_row = 0;        ///< transmissions: so many take it offline
  bus::Silence silence;                  ///< what it has left unanswered since it was heard
  Duration silent_for{0};                ///< how long ago the first of this was sent
  Duration held_back{0};                 ///< it still gets nothing but stops for so long
  Duration quarantine{0};                ///< how long it is held back after an unanswered request
  Duration least_quarantine{0};          ///< the same as it is configured, before late answers
  std::optional<Duration> next_probe;    ///< offline: in how long it is asked again at the earliest
  Duration response_timeout{0};
  /// How long ago two answers came to one request. Where the adapter receives what it sends, those
  /// do not count that may be an echo.
  std::optional<Duration> last_second_answer;
  std::optional<OtherWordOrder> other_order;
  /// The exception by which a server said last that it did not reach the device.
  std::optional<std::uint8_t> unreached;
  /// How long ago a stop was given up, with no write acknowledged since; and the exception with
  /// which it was refused, 0: it was unanswered.
  std::optional<Duration> last_failed_stop;
  std::uint8_t stop_exception = 0;
  bus::DeviceCounters counters;
  bus::QualityVerdict quality;
  bus::AnswerTimes times;  ///< of wire there are none on a connection
};

struct ListenerStatus {
  std::string name;
  std::size_t connections = 0;
  ListenerCounters counters;
  std::optional<Duration> last_failure{};  ///< RecentFailures::failed_at
};

struct ClientStatus {
  std::string address;
  std::string listener;
  std::uint64_t requests = 0;
  std::uint64_t refused = 0;    ///< of these, answered with an exception of the gateway's own
  std::size_t outstanding = 0;  ///< not answered yet
};

struct StatusReport {
  Duration uptime{0};
  ClientCounters counters;
  std::vector<BusStatus> buses;  ///< in the order of the configuration
  std::vector<DeviceStatus>
      devices;  ///< these too; then addresses that were asked without a device
  std::vector<ClientStatus> clients;  ///< if they were asked for
  std::vector<ListenerStatus> listeners;
};

/// Made on the thread that serves the buses: `with_clients` only for who shows each of them.
StatusReport make_status_report(const StatusView& view, bool with_clients);

}  // namespace mbgate::gateway
