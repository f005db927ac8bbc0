// SPDX-License-Identifier: Apache-2.0
// Clients that poll: each keeps a number of reads outstanding and asks again a little after each
// answer. What they got, and after how long, is kept for figures.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include "simulation/plants.hpp"

namespace mbgate::test {

/// Never zero where answers may come at once: such a client would ask for ever in the same instant.
inline constexpr Duration kThinkingTime = 500us;

struct Poller {
  std::size_t listener = 0;
  unsigned host = 0;
  std::size_t outstanding = 1;
  std::function<Registers()> next;  ///< what is asked next
  std::function<Duration()> thinks = [] { return kThinkingTime; };
};

struct Answer {
  std::size_t poller;
  Registers asked;
  Instant sent;
  Instant received;
  std::uint64_t sent_in_step;
  std::vector<std::uint8_t> pdu;
  [[nodiscard]] bool is_exception() const { return (pdu[0] & 0x80U) != 0; }
  [[nodiscard]] Duration latency() const { return received - sent; }
};

class Polling {
 public:
  using Look = std::function<void(const Answer&)>;

  Polling(const gateway::Settings& settings,
          const std::vector<std::vector<sim::DeviceSettings>>& devices)
      : world_(settings, devices,
               [this](ClientId client, modbus::Bytes adu) { take(client, adu); }) {}
  Polling(const Polling&) = delete;
  Polling& operator=(const Polling&) = delete;

  void add(Poller poller) {
    const std::size_t number = pollers_.size();
    clients_.push_back(world_.connect(poller.listener, poller.host));
    number_of_[clients_.back()] = number;
    pollers_.push_back(std::move(poller));
    open_.emplace_back();
    transaction_.push_back(0);
    for (std::size_t at = 0; at < pollers_.back().outstanding; ++at) {
      wakes_.emplace(world_.now() + pollers_.back().thinks(), number);
    }
  }
  /// Every answer is shown to `look`, from now on.
  void on_answer(Look look) { look_ = std::move(look); }
  /// Called before each step of the world, with its number.
  void before_step(std::function<void(std::uint64_t)> call) { before_step_ = std::move(call); }

  void run_for(Duration duration) {
    const Instant end = world_.now() + duration;
    while (world_.now() < end) {
      const auto wake = wakes_.empty() ? end : std::min(end, wakes_.begin()->first);
      world_.run(wake, [this, wake] {
        ++step_;
        if (before_step_) {
          before_step_(step_);
        }
        return !wakes_.empty() && wakes_.begin()->first < wake;
      });
      ask();
    }
  }
  [[nodiscard]] World& world() { return world_; }

 private:
  struct Open {
    Registers asked;
    Instant sent;
    std::uint64_t sent_in_step;
  };

  void ask() {
    while (!wakes_.empty() && wakes_.begin()->first <= world_.now()) {
      const std::size_t number = wakes_.begin()->second;
      wakes_.erase(wakes_.begin());
      const Registers asked = pollers_[number].next();
      const std::uint16_t transaction = ++transaction_[number];
      open_[number][transaction] = {asked, world_.now(), step_};
      world_.send(clients_[number],
                  adu(transaction, asked.unit, read_pdu(asked.first, asked.count)));
    }
  }
  void take(ClientId client, modbus::Bytes bytes) {
    const auto found = number_of_.find(client);
    if (found == number_of_.end()) {
      return;
    }
    const std::size_t number = found->second;
    const std::uint16_t transaction = modbus::load_be16(bytes, 0);
    const auto open = open_[number].find(transaction);
    ASSERT_NE(open, open_[number].end()) << "not asked, or answered twice";
    const Answer answer{number,       open->second.asked,        open->second.sent,
                        world_.now(), open->second.sent_in_step, {bytes.begin() + 7, bytes.end()}};
    open_[number].erase(open);
    wakes_.emplace(world_.now() + pollers_[number].thinks(), number);
    if (look_) {
      look_(answer);
    }
  }

  World world_;
  std::vector<Poller> pollers_;
  std::vector<ClientId> clients_;
  std::map<ClientId, std::size_t> number_of_;
  std::vector<std::map<std::uint16_t, Open>> open_;
  std::vector<std::uint16_t> transaction_;
  std::multimap<Instant, std::size_t> wakes_;
  Look look_;
  std::function<void(std::uint64_t)> before_step_;
  std::uint64_t step_ = 0;
};

/// One bus with a transparent listener, and a drive at each of the addresses.
struct OneBus {
  gateway::Settings settings;
  std::vector<std::vector<sim::DeviceSettings>> devices;
};

inline OneBus one_bus(const BusPlan& plan) {
  OneBus bus;
  bus.settings.buses.push_back(plan.bus);
  bus.settings.buses.back().name = "line";
  bus.devices.push_back(plan.devices);
  auto& listener = bus.settings.listeners.emplace_back();
  listener.name = "line";
  listener.bus = BusId{0};
  return bus;
}

/// Gives every user register of the drives its own value.
inline void fill_drives(World& world) {
  for (sim::Device& device : world.wire(0).devices()) {
    std::array<std::uint16_t, kRegisters> words{};
    for (std::uint16_t at = 0; at < kRegisters; ++at) {
      words[at] = value_of(device.settings().address, static_cast<std::uint16_t>(kFirst + at));
    }
    device.drive<sim::MoonsDrive>()->registers().write(kFirst, words);
  }
}

/// The registers that were asked for, each with its own value.
inline bool is_right(const Answer& answer) {
  return answer.pdu == data_pdu(answer.asked.unit, answer.asked.first, answer.asked.count);
}

}  // namespace mbgate::test
