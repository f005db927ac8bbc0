// SPDX-License-Identifier: Apache-2.0
#include "plant.hpp"

#include "modbus/frames.hpp"

namespace mbgate::bench {
namespace {

constexpr std::uint8_t kReadHoldingRegisters = 3;

std::uint8_t high(unsigned word) { return static_cast<std::uint8_t>(word >> 8U); }
std::uint8_t low(unsigned word) { return static_cast<std::uint8_t>(word & 0xFFU); }
unsigned word_at(const Frame& frame, std::size_t place) {
  return (static_cast<unsigned>(frame[place]) << 8U) | frame[place + 1];
}

/// The CRC goes out low byte first.
void append_crc(Frame& frame) {
  const unsigned crc = modbus::crc16(frame);
  frame.push_back(low(crc));
  frame.push_back(high(crc));
}

}  // namespace

Nanoseconds Plant::characters(std::size_t count) const {
  return paced() ? Nanoseconds(static_cast<std::int64_t>(count) * 10 * 1'000'000'000 / baud)
                 : Nanoseconds(0);
}

Nanoseconds Plant::t3_5() const {
  if (!paced()) {
    return Nanoseconds(0);
  }
  return baud > 19200 ? Nanoseconds(1'750'000) : characters(35) / 10;
}

Nanoseconds Plant::exchange() const {
  return characters(kRequestSize + response_size(registers)) + 2 * t3_5();
}

std::uint16_t register_value(unsigned bus, unsigned address, unsigned number) {
  return static_cast<std::uint16_t>((number * 40503U) ^ (address * 257U) ^ (bus * 8191U) ^ 0x5A5AU);
}

Frame make_request(unsigned address, unsigned first, unsigned registers) {
  Frame frame{low(address), kReadHoldingRegisters, high(first),
              low(first),   high(registers),       low(registers)};
  append_crc(frame);
  return frame;
}

Frame answer(unsigned bus, const Frame& request) {
  if (request.size() != kRequestSize || request[1] != kReadHoldingRegisters) {
    return {};
  }
  const unsigned first = word_at(request, 2);
  const unsigned count = word_at(request, 4);
  if (request != make_request(request[0], first, count) || count == 0 || count > 125) {
    return {};
  }
  Frame frame;
  frame.reserve(response_size(count));
  frame.insert(frame.end(), {request[0], request[1], low(2 * count)});
  for (unsigned place = 0; place < count; ++place) {
    const unsigned value = register_value(bus, request[0], first + place);
    frame.push_back(high(value));
    frame.push_back(low(value));
  }
  append_crc(frame);
  return frame;
}

}  // namespace mbgate::bench
