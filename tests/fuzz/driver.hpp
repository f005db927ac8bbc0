// SPDX-License-Identifier: Apache-2.0
// Stands where the driver stands: keeps to what the machine is promised, and checks what it
// promises, whatever the script does with clients, lines and time.
#pragma once

#include <deque>
#include <map>
#include <vector>

#include "fuzz/fuzz.hpp"
#include "fuzz/plant.hpp"
#include "modbus/frames.hpp"
#include "support/gateway_harness.hpp"

namespace mbgate::fuzz {

using gateway::BusId;
using gateway::ClientId;

class Driver {
 public:
  explicit Driver(gateway::Settings settings);

  void connect(std::uint32_t listener, std::uint8_t host, bool through_a_start);
  void client_bytes(std::size_t client, modbus::Bytes bytes);
  void half_close(std::size_t client);
  void disconnect(std::size_t client);
  /// One answer has been written whole.
  void confirm(std::size_t client);
  void line_bytes(std::size_t bus, modbus::Bytes bytes);
  void lose(std::size_t bus);
  /// Is a line that is asked for there?
  void set_present(std::size_t bus, bool present) { lines_[bus].present = present; }
  /// Does opening a line take until this is called again with false?
  void set_slow(std::size_t bus, bool slow);
  /// Other settings. `is_same`: they mean the same as those in force, at other places perhaps.
  void reload(gateway::Settings settings, bool is_same);
  void shutdown();
  /// It was not run for so long, and tells so.
  void stall(std::chrono::milliseconds missed) { feed(gateway::Stalled{missed}); }
  void clear_counters() { feed(gateway::ClearCountersAsked{}); }
  void advance(bus::Duration duration);
  /// Lets everything come to its end, with nobody but the clock at work: every request of a client
  /// that is still there must then have its answer.
  void finish();

  [[nodiscard]] std::size_t buses() const { return lines_.size(); }
  [[nodiscard]] std::size_t listeners() const { return harness_.settings().listeners.size(); }
  [[nodiscard]] bus::Framing framing(std::size_t bus) const {
    return harness_.settings().buses[bus].line.framing;
  }
  /// What the line has last heard from the machine.
  [[nodiscard]] const bus::FrameBytes& heard(std::size_t bus) const { return lines_[bus].heard; }

 private:
  struct Asked {
    std::uint8_t unit;
    std::uint8_t function;
    friend bool operator==(const Asked&, const Asked&) = default;
  };
  struct Client {
    bool open = true;
    bool ended = false;  ///< it has sent its FIN
    bool paused = false;
    std::size_t unconfirmed = 0;
    std::vector<std::uint8_t> stream;            ///< sent by it, and not yet a whole request
    std::multimap<std::uint16_t, Asked> due;     ///< requests without answer, by transaction
    std::deque<std::vector<std::uint8_t>> held;  ///< in the socket while reading is paused
  };
  struct Line {
    bool open = false;
    bool present = true;
    bool slow = false;
    bool asked = false;
    bool outdated = false;  ///< its settings have changed, so that it is to be closed first
    bus::FrameBytes heard;
  };

  Client* client_at(std::size_t index) {
    const auto entry = clients_.find(ClientId{index});
    return entry == clients_.end() || !entry->second.open ? nullptr : &entry->second;
  }
  void read(ClientId id, Client& client, modbus::Bytes bytes);
  void expect_answers(Client& client);
  void feed(const gateway::Input& input);
  void drain();
  [[nodiscard]] Line& line(BusId bus);
  bool serve_lines();
  bool serve_clients();
  void take(const gateway::Send& action);
  void take(const gateway::Pause& action);
  void take(const gateway::Resume& action);
  void take(const gateway::Close& action);
  void take(const gateway::Open& action);
  void take(const gateway::Look& action);
  void take(const gateway::Transmit& action);
  void take(const gateway::Shut& action);
  void take(const gateway::Report& action);
  void take(const gateway::Finished& action);

  test::GatewayHarness harness_;
  std::vector<Line> lines_;
  std::map<ClientId, Client> clients_;
  std::vector<ClientId> resumed_;
  std::uint64_t next_client_ = 0;
  bool undisturbed_ = false;  ///< nothing is to be done on account of the last input
  bool stopping_ = false;
  bool finished_ = false;
};

}  // namespace mbgate::fuzz
