// SPDX-License-Identifier: Apache-2.0
#include "sim/wire/wire.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::sim {
namespace {

std::vector<Device> make_devices(const std::vector<DeviceSettings>& drives,
                                 const WireSettings& wire) {
  std::vector<Device> devices;
  devices.reserve(drives.size());
  for (const DeviceSettings& device : drives) {
    devices.emplace_back(with_processing(device, wire.paced), wire.framing);
  }
  return devices;
}

Duration silence_of(const WireSettings& settings, const modbus::RtuTiming& timing) {
  if (settings.framing == Framing::ascii) {
    return Duration{0};
  }
  return settings.gap.value_or(settings.paced ? timing.t3_5() : Duration{0});
}

}  // namespace

bool understands(const PortMode& receiver, const PortMode& sender) {
  constexpr std::uint64_t kTolerance = 50;  // 2 %
  const auto wanted = static_cast<std::uint64_t>(receiver.baud);
  const auto sent = static_cast<std::uint64_t>(sender.baud);
  const auto apart = wanted > sent ? wanted - sent : sent - wanted;
  return receiver.format == sender.format && apart * kTolerance <= wanted;
}

Wire::Wire(const WireSettings& settings, const std::vector<DeviceSettings>& devices)
    : settings_(settings),
      timing_(settings.baud, settings.format),
      port_{settings.baud, settings.format},
      port_timing_(timing_),
      silence_(silence_of(settings, timing_)),
      devices_(make_devices(devices, settings)) {}

void Wire::set_port(const PortMode& mode) {
  if (mode == port_ || mode.baud == modbus::Baud{0}) {
    return;  // 0 baud hangs up
  }
  port_ = mode;
  port_timing_ = modbus::RtuTiming(mode.baud, mode.format);
}

void Wire::transmit(modbus::Bytes bytes, Instant begin) {
  if (bytes.empty()) {
    return;
  }
  const auto previous = std::ranges::find_if(
      on_wire_.rbegin(), on_wire_.rend(),
      [](const Transmission& transmission) { return transmission.from_gateway; });
  if (previous != on_wire_.rend()) {
    begin = std::max(begin, previous->end);
    previous->continued = settings_.clocking == Clocking::virtual_time && !previous->framed &&
                          begin < previous->end + silence_;
  }
  check_silence(begin);
  put_on_wire({.begin = begin,
               .end = begin + time_of(bytes.size(), true),
               .bytes = {bytes.begin(), bytes.end()},
               .from_gateway = true,
               .understood = understands({settings_.baud, settings_.format}, port_)});
}

std::optional<Instant> Wire::next_event() const {
  std::optional<Instant> next;
  if (!held_.empty()) {
    next = held_until_;
  }
  for (const Transmission& transmission : on_wire_) {
    next = bus::earlier(next, event_of(transmission));
  }
  return next;
}

std::vector<std::uint8_t> Wire::advance(Instant now) {
  for (auto at = next_event(); at && *at <= now; at = next_event()) {
    step(*at);
  }
  return std::exchange(received_, {});
}

void Wire::disconnect() {
  on_wire_.clear();
  ascii_.clear();
  held_.clear();
  received_.clear();
  last_end_.reset();
  echo_until_ = {};
}

Device* Wire::device(std::uint8_t address) {
  const auto found = std::ranges::find(
      devices_, address, [](const Device& device) { return device.settings().address; });
  return found == devices_.end() ? nullptr : &*found;
}

Duration Wire::time_of(std::size_t characters, bool from_gateway) const {
  const auto& timing = from_gateway ? port_timing_ : timing_;
  return settings_.paced ? timing.duration_of(characters) : Duration{0};
}

bool Wire::is_heard(const Transmission& transmission) const {
  return settings_.echo || !transmission.from_gateway;
}

std::optional<Instant> Wire::event_of(const Transmission& transmission) const {
  std::optional<Instant> at;
  if (is_heard(transmission) && transmission.delivered < transmission.bytes.size()) {
    at = transmission.next_delivery;
  }
  if (transmission.from_gateway && !transmission.framed && !transmission.continued) {
    at = bus::earlier(at, transmission.end + silence_);
  }
  return at;
}

// A transmission into the middle of another one is a collision, which put_on_wire() counts.
void Wire::check_silence(Instant begin) {
  std::optional<Instant> last = last_end_;
  bool answer = last_was_answer_;
  for (const Transmission& transmission : on_wire_) {
    if (transmission.begin <= begin && (!last || transmission.end > *last)) {
      last = transmission.end;
      answer = !transmission.from_gateway;
    }
  }
  const bool checked = settings_.clocking == Clocking::virtual_time || answer;
  if (last && checked && begin >= *last && begin - *last < silence_) {
    ++counters_.silence_violations;
  }
}

void Wire::put_on_wire(Transmission transmission) {
  if (settings_.format.data_bits == 7) {
    std::ranges::for_each(transmission.bytes, [](std::uint8_t& byte) { byte &= 0x7FU; });
  }
  plan_delivery(transmission);
  for (Transmission& other : on_wire_) {
    collide(transmission, other);
  }
  on_wire_.push_back(std::move(transmission));
}

void Wire::collide(Transmission& one, Transmission& other) {
  const Instant from = std::max(one.begin, other.begin);
  const Instant to = std::min(one.end, other.end);
  if (from < to) {
    ++counters_.collisions;
    garble(one, from, to);
    garble(other, from, to);
  }
}

// Two drivers against each other give neither's bits. What has been delivered before cannot change.
void Wire::garble(Transmission& transmission, Instant from, Instant to) const {
  for (std::size_t i = transmission.delivered; i < transmission.bytes.size(); ++i) {
    const bool hit = transmission.begin + time_of(i, transmission.from_gateway) < to &&
                     transmission.begin + time_of(i + 1, transmission.from_gateway) > from;
    if (hit) {
      transmission.bytes[i] = static_cast<std::uint8_t>(~transmission.bytes[i]);
    }
  }
}

void Wire::step(Instant at) {
  for (Transmission& transmission : on_wire_) {
    while (is_heard(transmission) && transmission.delivered < transmission.bytes.size() &&
           transmission.next_delivery <= at) {
      deliver(transmission);
    }
  }
  if (!held_.empty() && held_until_ <= at) {
    received_.insert(received_.end(), held_.begin(), held_.end());
    held_.clear();
  }
  settings_.framing == Framing::ascii ? close_ascii_frames(at) : close_frames(at);
  forget_what_is_over();
}

void Wire::deliver(Transmission& transmission) {
  auto& target = settings_.adapter_latency > Duration{0} ? held_ : received_;
  if (held_.empty()) {
    held_until_ = transmission.next_delivery + settings_.adapter_latency;
  }
  const auto begin = transmission.bytes.begin();
  target.insert(target.end(), begin + static_cast<std::ptrdiff_t>(transmission.delivered),
                begin + static_cast<std::ptrdiff_t>(transmission.next_count));
  transmission.delivered = transmission.next_count;
  plan_delivery(transmission);
}

// The first byte at its instant, then whatever has come every `chunk`, the last byte at its
// instant; but all in the order of the wire, even if an echo takes longer.
void Wire::plan_delivery(Transmission& transmission) {
  const std::size_t size = transmission.bytes.size();
  const std::size_t done = transmission.delivered;
  if (done >= size) {
    return;
  }
  std::size_t count = done + 1;
  while (done > 0 && count < size &&
         time_of(count, transmission.from_gateway) <
             time_of(done, transmission.from_gateway) + settings_.chunk) {
    ++count;
  }
  transmission.next_count = count;
  transmission.next_delivery = transmission.begin + time_of(count, transmission.from_gateway);
  if (transmission.from_gateway && settings_.echo) {
    transmission.next_delivery += settings_.echo_delay;
    echo_until_ = transmission.end + settings_.echo_delay;
  } else {
    transmission.next_delivery = std::max(transmission.next_delivery, echo_until_);
  }
}

void Wire::forget_what_is_over() {
  std::erase_if(on_wire_, [this](const Transmission& transmission) {
    const bool over =
        (!is_heard(transmission) || transmission.delivered == transmission.bytes.size()) &&
        (!transmission.from_gateway || transmission.framed);
    if (over && (!last_end_ || transmission.end >= *last_end_)) {
      last_end_ = transmission.end;
      last_was_answer_ = !transmission.from_gateway;
    }
    return over;
  });
}

}  // namespace mbgate::sim
