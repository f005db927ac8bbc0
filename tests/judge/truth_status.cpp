// SPDX-License-Identifier: Apache-2.0
// What the gateway says of itself when all is well again: the states of its devices, and its own
// unit, 255, in the layout that mbgated(8) promises.
#include <ranges>
#include <string_view>

#include "judge/rules_judge.hpp"

namespace mbgate::judge {
namespace {

constexpr unsigned kBuses = 1000;
constexpr unsigned kBusSize = 64;
constexpr unsigned kDevices = 10000;
constexpr unsigned kDeviceSize = 32;
constexpr unsigned kDiagnostics = 8;

void put(Words& words, std::size_t at, std::initializer_list<std::uint64_t> counters) {
  for (const std::uint64_t counter : counters) {
    words[at++] = counter >> 16U & 0xFFFFU;
    words[at++] = counter & 0xFFFFU;
  }
}

Words words_of(const gateway::BusStatus& bus) {
  Words words(kBusSize);
  words[0] = bus.is_open ? 1 : 0;
  words[1] = bus.waiting;
  const bus::BusCounters& it = bus.counters;
  put(words, 2, {it.transmissions, it.responses, it.exceptions, it.timeouts, it.bad_crcs});
  put(words, 20, {it.expired, it.refused_full, it.losses, it.retries, it.broadcasts});
  put(words, 42, {it.stops, it.stops_unanswered, it.overtaken_writes, it.probes});
  words[kBusSize - 1] = 0;
  return words;
}

Words words_of(const gateway::DeviceStatus& device) {
  Words words(kDeviceSize);
  words[0] = device.bus + 1;
  words[1] = device.address;
  words[2] =
      device.state == bus::DeviceState::answering ? std::optional<std::uint64_t>(1) : std::nullopt;
  words[3] = 0;
  const bus::DeviceCounters& it = device.counters;
  put(words, 4, {it.transmissions, it.responses, it.exceptions, it.timeouts, it.bad_crcs});
  words[kDeviceSize - 1] = 0;
  return words;
}

Octets object(std::uint8_t id, std::string_view text) {
  Octets octets{id, low(static_cast<unsigned>(text.size()))};
  octets.insert(octets.end(), text.begin(), text.end());
  return octets;
}

template <typename Things>
Words words_of_all(const Things& things) {
  Words words;
  for (const auto& thing : things) {
    const Words block = words_of(thing);
    words.insert(words.end(), block.begin(), block.end());
  }
  return words;
}

}  // namespace

// Nothing where rules or rates are in the way.
std::optional<Octets> RulesJudge::ask_gateway(const Octets& pdu) {
  constexpr std::uint16_t kInTheWay = code(1) | code(6);
  const auto answer = world_.ask_gateway(pdu, 1s);
  const bool is_refused = answer && (*answer)[0] >= 0x80 && (code((*answer)[1]) & kInTheWay) != 0;
  return is_refused ? std::nullopt : answer;
}

void RulesJudge::expect(const Octets& pdu, const Octets& begin, std::optional<std::size_t> size) {
  const auto answer = ask_gateway(pdu);
  if (answer && (!std::ranges::equal(begin, *answer | std::views::take(begin.size())) ||
                 (size && answer->size() != *size))) {
    report_.violation("own_unit", hex(pdu) + ": " + hex(*answer) + ", must be " + hex(begin));
  }
}

// Blocks one behind the other, and nothing behind the last. What they count may go on meanwhile.
void RulesJudge::check_blocks(unsigned first, const std::function<Words()>& expected) {
  const Words before = expected();
  constexpr std::size_t kMost = 100;
  for (std::size_t at = 0; at < before.size(); at += kMost) {
    const std::size_t count = std::min(kMost, before.size() - at);
    const Octets pdu = request(4, first + static_cast<unsigned>(at), static_cast<unsigned>(count));
    const auto answer = ask_gateway(pdu);
    const Words after = expected();
    for (std::size_t word = 0; answer && word < count; ++word) {
      const bool is_there = answer->size() == 2 + 2 * count;
      const std::uint64_t shown = is_there ? word_at(*answer, 2 + 2 * word) : 0;
      if (!is_there || (shown != before[at + word].value_or(shown) &&
                        shown != after[at + word].value_or(shown))) {
        report_.violation("own_unit", hex(pdu) + ": " + hex(*answer) + ", register " +
                                          std::to_string(first + at + word));
        return;
      }
    }
  }
  expect(request(4, first + static_cast<unsigned>(before.size()) - 1, 2), {0x84, 2}, 2);
}

void RulesJudge::check_identity() {
  const Octets name = object(0, "mbgate");
  const auto answer_of = [&](std::uint8_t kind, std::uint8_t count, const Octets& first) {
    Octets answer{0x2B, kIdentification, kind, 0x82, 0, 0, count};
    answer.insert(answer.end(), first.begin(), first.end());
    return answer;
  };
  const auto ask = [](std::uint8_t kind, std::uint8_t from) {
    return Octets{0x2B, kIdentification, kind, from};
  };
  expect(ask(1, 0), answer_of(1, 3, name));
  expect(ask(1, 1), answer_of(1, 2, object(1, "mbgated")));
  expect(ask(1, 4), answer_of(1, 3, name));
  expect(ask(2, 0), answer_of(2, 4, name));
  expect(ask(4, 1), answer_of(4, 1, object(1, "mbgated")));
  expect(ask(4, 3), {0xAB, 2}, 2);
  expect(ask(5, 0), {0xAB, 3}, 2);
  expect({0x2B, 0x0D, 1, 0}, {0xAB, 1}, 2);  // another kind of encapsulation, and a write
  expect(request(6, 0, 0), {0x86, 1}, 2);
}

// All buses together, in 16 bits.
void RulesJudge::check_diagnostics(const gateway::StatusReport& status) {
  std::map<unsigned, std::uint64_t> sums;
  for (const gateway::BusStatus& bus : status.buses) {
    sums[0x0C] += bus.counters.bad_crcs;
    sums[0x0D] += bus.counters.exceptions;
    sums[0x0F] += bus.counters.timeouts;
    sums[0x11] += bus.counters.refused_full;
  }
  for (const auto& [sub_function, sum] : sums) {
    expect(request(kDiagnostics, sub_function, 0),
           request(kDiagnostics, sub_function, static_cast<unsigned>(sum & 0xFFFFU)), 5);
  }
  expect(request(kDiagnostics, 0, 0x1234), request(kDiagnostics, 0, 0x1234), 5);
}

void RulesJudge::check_states(const gateway::StatusReport& status) {
  for (const gateway::DeviceStatus& device : status.devices) {
    const bool is_well = device.state == bus::DeviceState::answering && device.has_answered &&
                         device.unanswered_in_row == 0 && device.state_since &&
                         *device.state_since <= world_.now() - ledger_.started;
    if (!is_well) {
      report_.violation("not_well", device.name);
    }
  }
}

// Each request was counted for its device, and for its bus. A reload may have taken devices away.
void RulesJudge::check_sums(const gateway::StatusReport& status) {
  if (ledger_.reloaded >= ledger_.started) {
    return;
  }
  for (std::size_t at = 0; at < status.buses.size(); ++at) {
    const bus::BusCounters& it = status.buses[at].counters;
    const auto is_sum = [&](const char* what, std::uint64_t shown, auto counter) {
      std::uint64_t sum = 0;
      for (const gateway::DeviceStatus& device : status.devices) {
        sum += device.bus == at ? device.counters.*counter : 0;
      }
      compare(status.buses[at].name + ": sum of " + what, sum, {shown, shown});
    };
    using Device = bus::DeviceCounters;
    is_sum("transmissions", it.transmissions - it.broadcasts, &Device::transmissions);
    is_sum("responses", it.responses, &Device::responses);
    is_sum("exceptions", it.exceptions, &Device::exceptions);
    is_sum("timeouts", it.timeouts, &Device::timeouts);
    is_sum("bad CRCs", it.bad_crcs, &Device::bad_crcs);
    is_sum("late responses", it.late_responses, &Device::late_responses);
  }
}

void RulesJudge::check_cleared() {
  const Octets clear = request(kDiagnostics, 0x0A, 0);
  const auto answer = ask_gateway(clear);
  if (!answer) {
    return;
  }
  if (*answer != clear) {
    report_.violation("own_unit", hex(clear) + ": " + hex(*answer));
  }
  const auto status = world_.gateway().report_status(0s, world_.now());
  std::uint64_t left = status.counters.requests;
  for (const gateway::BusStatus& bus : status.buses) {
    left += bus.counters.transmissions + bus.counters.responses + bus.counters.timeouts;
  }
  for (const gateway::DeviceStatus& device : status.devices) {
    left += device.counters.transmissions + device.counters.responses;
  }
  for (const gateway::ListenerStatus& listener : status.listeners) {
    left += listener.counters.requests + listener.counters.connections;
  }
  if (left > 0) {
    report_.violation("not_cleared", std::to_string(left) + " are left");
  }
  expect(request(kDiagnostics, 0x0E, 0), request(kDiagnostics, 0x0E, 1), 5);
}

void RulesJudge::check_status() {
  world_.run_for(5s);  // a failsafe write may be under way
  const auto read = [this] {
    auto status = world_.gateway().report_status(0s, world_.now());
    std::erase_if(status.devices, [](const auto& device) { return device.name.empty(); });
    return status;
  };
  check_sums(world_.gateway().report_status(0s, world_.now()));
  const auto status = read();
  check_states(status);
  expect(request(4, 0, 3),
         {4, 6, 0, 2, 0, low(static_cast<unsigned>(status.buses.size())), 0,
          low(static_cast<unsigned>(status.devices.size()))},
         8);
  check_blocks(kBuses, [&] { return words_of_all(read().buses); });
  check_blocks(kDevices, [&] { return words_of_all(read().devices); });
  check_identity();
  check_diagnostics(status);
  check_cleared();
}

}  // namespace mbgate::judge
