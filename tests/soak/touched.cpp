// SPDX-License-Identifier: Apache-2.0
#include "soak/touched.hpp"

#include <algorithm>

namespace mbgate::soak {
namespace {

constexpr std::uint8_t kBothWays = 0x17;
constexpr std::uint8_t kFifo = 0x18;
constexpr std::uint8_t kNotPossibleNow = 6;
constexpr std::uint8_t kAutonicsForm = 0x80;  // of the function

// What is neither is a write.
bool is_reading(const PduBytes& pdu) {
  switch (pdu.front()) {
    case 0x01:
    case 0x02:
    case 0x03:
    case 0x04:
    case 0x07:
    case 0x0B:
    case 0x0C:
    case 0x11:
    case 0x14:
    case kFifo: return true;
    case 0x2B: return pdu.size() > 1 && pdu[1] == 0x0E;
    default: return false;
  }
}

// What is masked may stop, whatever is written. Only a stop that goes by itself is one, in the
// register of stops with so many parameters behind it.
StopAmong stop_among(std::uint8_t function, const spec::Fields& fields, unsigned parameters) {
  constexpr unsigned kOfStops = 0xF000;
  constexpr unsigned kStop = 0x5000;
  constexpr std::uint8_t kMask = 0x16;
  const spec::Range& range = *fields.writes;
  const bool are_coils = range.table == Table::coils;
  const unsigned stop = are_coils ? kStopCoil : kStopRegister;
  if (stop < range.first || stop >= range.first + range.count) {
    return StopAmong::none;
  }
  if (function == kMask) {
    return StopAmong::others;
  }
  const unsigned value = fields.words[stop - range.first];
  if (are_coils ? value == 0 : (value & kOfStops) != kStop) {
    return StopAmong::none;
  }
  const bool is_alone = range.first == stop && range.count <= 1 + (are_coils ? 0 : parameters) &&
                        function != kBothWays;
  return is_alone ? StopAmong::alone : StopAmong::others;
}

std::vector<std::optional<std::size_t>> receivers_of(const SoakPlan& plan, const Asked& asked,
                                                     const Piece& piece) {
  if (asked.door->device) {
    return {asked.door->device};
  }
  // In whichever form it goes out, it counts as one to everybody there.
  std::vector<std::optional<std::size_t>> receivers;
  for (std::size_t index = 0; index < plan.settings.devices.size(); ++index) {
    const auto bus = static_cast<std::size_t>(plan.settings.devices[index].bus);
    if (bus == piece.bus && !plan.absent.devices[index]) {
      receivers.emplace_back(index);
    }
  }
  return receivers;
}

}  // namespace

std::vector<Half> halves_of(const SoakPlan& plan, const Asked& asked) {
  Half reading{.reads = true};
  Half writing{.reads = false};
  const auto add = [&](std::optional<std::size_t> device, PduBytes pdu) {
    const bool is_for_all = asked.door != nullptr && !asked.door->device;
    pdu[0] = static_cast<std::uint8_t>(is_for_all ? pdu[0] & ~kAutonicsForm : pdu[0]);
    spec::Fields fields = spec::fields_of(pdu).value_or(spec::Fields{});
    if (pdu[0] == kFifo) {
      fields.reads = spec::Range{Table::holding_registers, spec::word_at(pdu, 1), 1};
    }
    if (fields.reads) {
      reading.touched.push_back({device, fields.reads});
    }
    if (fields.writes) {
      const auto& profile = plan.settings.devices[device.value_or(0)].profile;
      const auto stop =
          device ? stop_among(pdu[0], fields, profile.stops.front().parameters) : StopAmong::none;
      writing.touched.push_back({device, fields.writes, stop});
    }
    if (!fields.reads && !fields.writes) {
      (is_reading(pdu) ? reading : writing).touched.push_back({device, std::nullopt});
    }
  };
  const bool is_understood = !asked.refused || asked.refused == kNotPossibleNow;
  if (!is_understood || (asked.pieces.empty() && asked.kind != Kind::own)) {
    return {{.reads = is_reading(asked.pdu), .is_known = false}};
  }
  if (asked.kind == Kind::own) {
    add(std::nullopt, asked.pdu);
  }
  for (const Piece& piece : asked.pieces) {
    for (const auto device : receivers_of(plan, asked, piece)) {
      if (!piece.asks_order) {
        add(device, piece.pdu);
      }
    }
  }
  std::vector<Half> halves{writing, reading};
  std::erase_if(halves, [](const Half& half) { return half.touched.empty(); });
  return halves;
}

}  // namespace mbgate::soak
