// SPDX-License-Identifier: Apache-2.0
// Follows requests while somebody reads along: what came from the client, what went on the wire for
// it, what was heard, what the client got. It only looks: nothing is decided differently because of
// it. While nobody reads, every caller asks is_on() and does nothing else.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bus/bus_action.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "gateway/trace/line_trace.hpp"
#include "gateway/trace/trace_record.hpp"
#include "modbus/mbap.hpp"
#include "routing/plan.hpp"

namespace mbgate::gateway {

class TraceBook {
 public:
  /// What is kept of a request, and until it is taken: a stuck reader costs memory, and these say
  /// how much.
  static constexpr std::size_t kMostWires = 64;  ///< transmissions of one request
  static constexpr std::size_t kMostRecords = 2048;

  explicit TraceBook(const SettingsHistory& settings) : settings_(settings) {}

  [[nodiscard]] bool is_on() const { return on_; }
  /// Off: everything is forgotten. On: what is asked from now on is traced.
  void set_on(bool on);
  /// So many transmissions of these buses began before anybody read along: what is heard of them is
  /// not told.
  void begin_amid(const std::vector<std::pair<BusId, std::size_t>>& in_flight);

  /// A request that is answered at once.
  void refused(AskedTrace asked);
  /// A request is carried out; `exchange` names it until it is answered.
  void asked(std::uint32_t exchange, AskedTrace asked, const routing::Plan& plan);
  struct Answer {
    const std::optional<modbus::MbapAdu>& adu;  ///< nothing: none is given
    std::optional<bus::Ending> ended_as;
    Instant at;
  };
  void answered(std::uint32_t exchange, const Answer& answer);

  /// What comes from the line now is no part of what came before.
  void opened(BusId bus, Instant now);
  void began(BusId bus, const bus::TransmissionBegan& began, Instant now);
  /// The frame of the transmission that began last on this bus.
  void transmitted(BusId bus, modbus::Bytes frame);
  /// To be called before the bus gets the bytes.
  void heard(BusId bus, modbus::Bytes bytes, Instant now);
  void over(BusId bus, const bus::TransmissionOver& over, Instant now);

  struct Taken {
    std::vector<TraceRecord> records;
    std::size_t lost = 0;  ///< that were not taken in time
  };
  /// What has come to its end since the last call. Bytes that nobody asked for come to their end
  /// with a pause.
  Taken take(Instant now);

 private:
  /// What is known of a frame before anything was sent; address 0: of the line alone.
  [[nodiscard]] WireTrace blank(BusId bus, std::uint8_t address = 0) const;
  /// Takes over what has come to its end on the line.
  void collect(LineTrace& line);
  void give(const LineTrace::Told& told);
  void finish(TraceRecord record);

  const SettingsHistory& settings_;
  bool on_ = false;
  std::unordered_map<std::uint32_t, TraceRecord> open_;
  std::map<BusId, LineTrace> lines_;
  std::deque<TraceRecord> finished_;
  std::size_t lost_ = 0;
};

}  // namespace mbgate::gateway
