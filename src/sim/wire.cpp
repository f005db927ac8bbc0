// SPDX-License-Identifier: Apache-2.0
#include "sim/wire.hpp"

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

Wire::Wire(const WireSettings& settings, const std::vector<DeviceSettings>& devices)
    : settings_(settings),
      timing_(settings.baud, settings.format),
      silence_(silence_of(settings, timing_)),
      devices_(make_devices(devices, settings)) {}

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
               .end = begin + time_of(bytes.size()),
               .bytes = {bytes.begin(), bytes.end()},
               .from_gateway = true});
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
}

Device* Wire::device(std::uint8_t address) {
  const auto found = std::ranges::find(
      devices_, address, [](const Device& device) { return device.settings().address; });
  return found == devices_.end() ? nullptr : &*found;
}

Duration Wire::time_of(std::size_t characters) const {
  return settings_.paced ? timing_.duration_of(characters) : Duration{0};
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
    const bool hit =
        transmission.begin + time_of(i) < to && transmission.begin + time_of(i + 1) > from;
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
// instant.
void Wire::plan_delivery(Transmission& transmission) const {
  const std::size_t size = transmission.bytes.size();
  const std::size_t done = transmission.delivered;
  if (done >= size) {
    return;
  }
  std::size_t count = done + 1;
  while (done > 0 && count < size && time_of(count) < time_of(done) + settings_.chunk) {
    ++count;
  }
  transmission.next_count = count;
  transmission.next_delivery = transmission.begin + time_of(count);
}

void Wire::close_frames(Instant at) {
  std::vector<FrameOnWire> closed;
  std::vector<Transmission*> parts;
  for (Transmission& transmission : on_wire_) {
    if (!transmission.from_gateway || transmission.framed) {
      continue;
    }
    parts.push_back(&transmission);
    if (transmission.continued) {
      continue;
    }
    if (transmission.end + silence_ <= at) {
      closed.push_back(join(parts));
    }
    parts.clear();
  }
  for (FrameOnWire& frame : closed) {
    hand_to_devices(std::move(frame));
  }
}

// A frame may come in several transmissions, and one transmission may carry several frames.
void Wire::close_ascii_frames(Instant at) {
  std::vector<FrameOnWire> closed;
  for (Transmission& transmission : on_wire_) {
    if (!transmission.from_gateway || transmission.framed || transmission.end > at) {
      continue;
    }
    transmission.framed = true;
    for (std::size_t i = 0; i < transmission.bytes.size(); ++i) {
      const Instant begin = transmission.begin + time_of(i);
      if (auto frame = ascii_.feed(transmission.bytes[i], begin, begin + time_of(1))) {
        closed.push_back({.begin = frame->begin, .end = frame->end, .bytes = frame->bytes});
      }
    }
  }
  for (FrameOnWire& frame : closed) {
    hand_to_devices(std::move(frame));
  }
}

FrameOnWire Wire::join(const std::vector<Transmission*>& parts) {
  FrameOnWire frame{.begin = parts.front()->begin, .end = parts.back()->end};
  for (Transmission* part : parts) {
    frame.bytes.insert(frame.bytes.end(), part->bytes.begin(), part->bytes.end());
    part->framed = true;
  }
  return frame;
}

void Wire::hand_to_devices(FrameOnWire frame) {
  frame.intact = decode_frame(settings_.framing, frame.bytes).has_value();
  ++counters_.frames;
  counters_.bad_crc += frame.intact ? 0U : 1U;
  for (Device& device : devices_) {
    const std::uint64_t before = device.heard();
    const auto answer = device.receive(frame.bytes, frame.end);
    if (device.heard() != before) {
      frame.heard_by.push_back(device.settings().address);
    }
    if (answer) {
      ++counters_.answers;
      const Duration wait =
          answer->counts_from_end ? std::max(silence_, answer->after) : silence_ + answer->after;
      put_on_wire({.begin = frame.end + wait,
                   .end = frame.end + wait + time_of(answer->frame.size()),
                   .bytes = {answer->frame.begin(), answer->frame.end()},
                   .from_gateway = false});
    }
  }
  frames_.push_back(std::move(frame));
  while (frames_.size() > settings_.frames_kept) {
    frames_.pop_front();
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
