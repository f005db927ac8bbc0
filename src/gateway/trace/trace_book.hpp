// SPDX-License-Identifier: Apache-2.0
// Follows requests while somebody reads along: what came from the client, what went on the wire for
// it, what was heard, what the client got. It only looks: nothing is decided differently because of
// it. While nobody reads, every caller asks is_on() and does nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bus/bus_action.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "gateway/trace/trace_record.hpp"
#include "modbus/bytes.hpp"
#include "modbus/mbap.hpp"
#include "routing/plan.hpp"

namespace mbgate::gateway {

// Follows one line for a trace: assigns the bytes that were heard to transmissions.

class LineTrace {
 public:
  /// What is kept of a transmission: twice what the longest answer has, in ASCII.
  static constexpr std::size_t kMostHeard = 1024;

  /// A transmission. Without requests: bytes that nobody had asked for.
  struct Told {
    bus::TransmissionTitle title;
    WireTrace wire;
  };

  /// So many transmissions are on the wire that are not traced: what is heard is theirs.
  void begin_amid(std::size_t in_flight) { from_before_ = in_flight; }
  /// What comes now is no part of what came before. `blank` has what is known of the line alone.
  void opened(const WireTrace& blank, Instant now);
  /// `wire` has what is known before anything was sent.
  void began(const bus::TransmissionBegan& began, WireTrace wire);
  /// The frame of the transmission that began last.
  void transmitted(modbus::Bytes frame);
  /// To be called before the bus gets the bytes.
  void heard(modbus::Bytes bytes, const WireTrace& blank, Instant now);
  void over(const bus::TransmissionOver& over, Instant now);
  /// The request is answered: what is still on the wire for it was cut.
  void answered(std::uint32_t request, Instant now);
  /// Bytes that nobody had asked for come to their end with a pause, or after a while.
  void rest(Instant now);

  /// What has come to its end.
  std::vector<Told> take() { return std::exchange(reported_, {}); }

 private:
  void hear_adus(modbus::Bytes bytes, const WireTrace& blank, Instant now);
  /// An ADU, or the beginning of one.
  void hear_adu(modbus::Bytes adu, const WireTrace& blank, Instant now);
  void hear_unasked(modbus::Bytes bytes, const WireTrace& blank, Instant now);
  void end_unasked();
  /// Those of the transmissions on the wire are cut for which `is_cut` holds.
  template <typename IsCut>
  void cut(IsCut is_cut, Instant now);

  std::vector<Told> in_flight_;
  std::optional<WireTrace> unasked_;
  ByteString partial_;  // of a connection: the beginning of an ADU
  std::size_t from_before_ = 0;
  ByteString echo_;  // of a broadcast: it may be heard when the transaction is over
  std::vector<Told> reported_;
};

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
  /// So many transmissions of the bus began before anybody read along: what is heard of them is not
  /// told.
  void begin_amid(BusId bus, std::size_t in_flight) { lines_[bus].begin_amid(in_flight); }

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
  /// What a bus does. Much of it does not matter here.
  void acted(BusId bus, const bus::BusAction& action, Instant now);
  /// To be called before the bus gets the bytes.
  void heard(BusId bus, modbus::Bytes bytes, Instant now);

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
  void finish(TraceRecord record);

  const SettingsHistory& settings_;
  bool on_ = false;
  std::unordered_map<std::uint32_t, TraceRecord> open_;
  std::map<BusId, LineTrace> lines_;
  std::deque<TraceRecord> finished_;
  std::size_t lost_ = 0;
};

}  // namespace mbgate::gateway
