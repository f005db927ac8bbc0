// SPDX-License-Identifier: Apache-2.0
#include "gateway/status_unit.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>

#include "modbus/request.hpp"

namespace mbgate::gateway {
namespace {

using modbus::ExceptionCode;
using modbus::Pdu;

constexpr std::uint32_t kLayoutVersion = 2;
constexpr std::uint32_t kBusesAt = 1000;
constexpr std::uint32_t kBusSize = 64;
constexpr std::uint32_t kDevicesAt = 10000;
constexpr std::uint32_t kDeviceSize = 32;

using Block = std::vector<std::uint16_t>;

void put32(Block& block, std::uint64_t value) {
  block.push_back(static_cast<std::uint16_t>((value >> 16U) & 0xFFFFU));
  block.push_back(static_cast<std::uint16_t>(value & 0xFFFFU));
}

std::uint16_t saturated(std::uint64_t value) {
  return static_cast<std::uint16_t>(
      std::min<std::uint64_t>(value, std::numeric_limits<std::uint16_t>::max()));
}

Block head_block(const StatusView& view) {
  Block block{kLayoutVersion, saturated(view.buses.size()), saturated(view.devices.size()),
              saturated(view.sessions.size())};
  const auto uptime = std::chrono::floor<std::chrono::seconds>(view.now - view.started);
  put32(block, static_cast<std::uint64_t>(uptime.count()));
  put32(block, view.counters.requests);
  put32(block, view.counters.foreign_adus);
  put32(block, view.counters.framing_lost);
  return block;
}

// In the order of docs/status.md.
void put_quality(Block& block, const bus::QualityVerdict& verdict) {
  block.push_back(static_cast<std::uint16_t>(verdict.quality));
  block.push_back(saturated(verdict.quality == bus::Quality::bad_crc ? verdict.percent() : 0));
}

Block bus_block(const bus::Bus& bus) {
  const bus::BusCounters& counters = bus.counters();
  Block block{static_cast<std::uint16_t>(bus.link().serves() ? 1 : 0),
              saturated(bus.parts().waiting())};
  std::array<std::uint64_t, bus::kCounterPlaces> counts{};
  for (const bus::CounterKind& counter : bus::kBusCounters) {
    counts.at(counter.place) = counters.*counter.member;
  }
  for (const std::uint64_t count : counts) {
    put32(block, count);
  }
  put_quality(block, bus.diagnosis().quality().verdict());
  block.resize(kBusSize);
  return block;
}

// Milliseconds begun, so that 0 means that it is over.
std::uint16_t milliseconds(bus::Duration duration) {
  return saturated(
      static_cast<std::uint64_t>(std::chrono::ceil<std::chrono::milliseconds>(duration).count()));
}

Block device_block(const Settings::WrittenDevice& shown, const StatusView& view) {
  const drive::Device& device = *shown.device;
  const bus::Bus& bus = view.all[view.buses[shown.bus]];
  const bus::DeviceEntry& entry = bus.devices()[device.address];
  const bus::DeviceCounters& counters = entry.counters;
  const bus::QualityVerdict& quality = bus.diagnosis().quality()[device.address].verdict();
  Block block{static_cast<std::uint16_t>(shown.bus + 1), device.address,
              static_cast<std::uint16_t>(bus.parts().state_of(device.address)),
              saturated(entry.health.unanswered_in_row())};
  for (const std::uint64_t count :
       {counters.transmissions, counters.responses, counters.exceptions, counters.timeouts,
        counters.bad_crcs, counters.late_responses, counters.early_responses}) {
    put32(block, count);
  }
  block.push_back(entry.health.is_offline() ? 1 : 0);
  block.push_back(milliseconds(bus.parts().held_back(device.address, view.now)));
  put32(block, counters.noise_bytes);
  put_quality(block, quality);
  block.push_back(milliseconds(quality.needed));
  block.resize(kDeviceSize);
  return block;
}

// The block of registers that begins at or before `address`, and where it begins.
std::pair<std::uint32_t, Block> block_at(std::uint32_t address, const StatusView& view) {
  if (address >= kDevicesAt) {
    const std::uint32_t index = (address - kDevicesAt) / kDeviceSize;
    if (index >= view.devices.size()) {
      return {};
    }
    return {kDevicesAt + index * kDeviceSize, device_block(view.devices[index], view)};
  }
  if (address >= kBusesAt) {
    const std::uint32_t index = (address - kBusesAt) / kBusSize;
    return index < view.buses.size()
               ? std::pair{kBusesAt + index * kBusSize, bus_block(view.all[view.buses[index]])}
               : std::pair<std::uint32_t, Block>{};
  }
  return {0, head_block(view)};
}

Pdu read_registers(const modbus::TableRange& range, const StatusView& view) {
  std::vector<std::uint8_t> bytes{0x04, static_cast<std::uint8_t>(range.count * 2)};
  for (std::uint32_t address = range.first; address < std::uint32_t{range.first} + range.count;) {
    const auto [begin, block] = block_at(address, view);
    if (address - begin >= block.size()) {
      return Pdu::exception(0x04, ExceptionCode::illegal_data_address);
    }
    for (std::uint32_t at = address - begin;
         at < block.size() && address < std::uint32_t{range.first} + range.count; ++at, ++address) {
      bytes.push_back(static_cast<std::uint8_t>(block[at] >> 8U));
      bytes.push_back(static_cast<std::uint8_t>(block[at] & 0xFFU));
    }
  }
  return *Pdu::from(bytes);
}

struct Object {
  std::uint8_t id;
  std::string_view value;
};
// Application Protocol V1.1b3, 6.21: 00-02 basic, 04 regular.
constexpr std::array kObjects{Object{0x00, "mbgate"}, Object{0x01, "mbgated"},
                              Object{0x02, MBGATE_VERSION},
                              Object{0x04, "Modbus TCP to RTU gateway"}};
constexpr std::uint8_t kLastBasicObject = 0x02;
constexpr std::uint8_t kRegularConformity = 0x82;  // stream and individual access

Pdu identify(const Pdu& request) {
  const std::uint8_t code = request.bytes()[2];
  const std::uint8_t first = request.bytes()[3];
  if (code < 1 || code > 4) {
    return Pdu::exception(request.function(), ExceptionCode::illegal_data_value);
  }
  const auto in_reach = [code](const Object& object) {
    return code > 1 || object.id <= kLastBasicObject;
  };
  const bool known = std::ranges::any_of(
      kObjects, [&](const Object& object) { return object.id == first && in_reach(object); });
  if (code == 4 && !known) {
    return Pdu::exception(request.function(), ExceptionCode::illegal_data_address);
  }
  // A stream that begins at an object that it does not have restarts at the first one.
  const std::uint8_t from = known ? first : std::uint8_t{0};
  std::vector<std::uint8_t> bytes{
      request.function(), modbus::kReadDeviceIdentification, code, kRegularConformity, 0, 0, 0};
  for (const Object& object : kObjects) {
    const bool wanted = code == 4 ? object.id == from : object.id >= from && in_reach(object);
    if (wanted) {
      ++bytes[6];
      bytes.push_back(object.id);
      bytes.push_back(static_cast<std::uint8_t>(object.value.size()));
      bytes.insert(bytes.end(), object.value.begin(), object.value.end());
    }
  }
  return *Pdu::from(bytes);
}

}  // namespace

StatusUnit::Answer StatusUnit::diagnose(const Pdu& request, const StatusView& view) const {
  using Counters = bus::BusCounters;
  const auto sum = [&](auto... counters) {
    std::uint64_t total = 0;
    for (const BusId bus : view.buses) {
      total += (... + (view.all[bus].counters().*counters));
    }
    return total;
  };
  std::uint64_t value = 0;
  switch (modbus::load_be16(request.bytes(), 1)) {
    case 0x00: return {request};
    case 0x02: break;  // diagnostic register: nothing to tell
    case 0x0A: return {request, true};
    case 0x0B: value = sum(&Counters::responses, &Counters::unsolicited_frames); break;
    case 0x0C: value = sum(&Counters::bad_crcs); break;
    case 0x0D: value = sum(&Counters::exceptions); break;
    case 0x0E: value = requests_; break;
    case 0x0F: value = sum(&Counters::timeouts); break;
    case 0x10: break;  // NAK count: the gateway sends none
    case 0x11: value = sum(&Counters::refused_full); break;
    case 0x12: break;  // character overrun count: not seen by the gateway
    default: return {Pdu::exception(request.function(), ExceptionCode::illegal_function)};
  }
  Pdu answer = *Pdu::from(request.bytes().first(5));
  answer.set_be16(3, static_cast<std::uint16_t>(value & 0xFFFFU));
  return {answer};
}

StatusUnit::Answer StatusUnit::answer(const Pdu& request, const StatusView& view) {
  ++requests_;
  const auto parsed = modbus::Request::parse(request);
  if (!parsed) {
    return {Pdu::exception(request.function(), parsed.error())};
  }
  if (parsed->function() == 0x04) {
    return {read_registers(parsed->reads()->range, view)};
  }
  if (parsed->function() == 0x08) {
    return diagnose(request, view);
  }
  if (parsed->function() == 0x2B && request.bytes()[1] == modbus::kReadDeviceIdentification) {
    return {identify(request)};
  }
  return {Pdu::exception(request.function(), ExceptionCode::illegal_function)};
}

}  // namespace mbgate::gateway
