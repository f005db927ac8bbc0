// SPDX-License-Identifier: Apache-2.0
// What another client on the line asks.
#include "soak/pdus.hpp"
#include "soak/serial_wire.hpp"

namespace mbgate::soak {
namespace {

constexpr unsigned kOtherFunctions = 600;  // permille of what strangers ask

}  // namespace

// Of every function. What it writes no client of the gateway writes.
std::vector<std::uint8_t> SerialWire::strange_request() {
  if (!echo_random_.chance(kOtherFunctions)) {
    const unsigned first = static_cast<unsigned>(around_.random.below(60));
    return fields(3, first, around_.random.between(1U, 10U));
  }
  const unsigned at = echo_random_.between(0U, 30U);
  const auto count = [this](unsigned most) { return echo_random_.between(1U, most); };
  const auto value = static_cast<std::uint16_t>(0xC000U | at);
  switch (echo_random_.between(0U, 18U)) {
    case 0: return fields(1, kFirstRunOfCoils + at, count(100));
    case 1: return fields(2, at, count(100));
    case 2: return fields(4, at, count(20));
    case 3: return fields(5, kFirstRunOfCoils + at, at % 2 == 0 ? kOn : 0);
    case 4: return fields(6, at, value);
    case 5: return coils_pdu(kFirstRunOfCoils + at, {value});
    case 6: return multiple_pdu(at, std::vector<std::uint16_t>(count(4), value));
    case 7: return {0x16, 0, low(at), 0xFF, 0xFF, high(value), low(value)};
    case 8: {
      PduBytes pdu = fields(0x17, at, count(8));
      append_word(pdu, at);
      append_word(pdu, 1);
      append_words(pdu, {value});
      return pdu;
    }
    case 9: return {0x07};
    case 10: return {0x0B};
    case 11: return {0x0C};
    case 12: return {0x11};
    case 13: return {0x14, 7, 6, 0, 4, 0, low(at), 0, low(count(8))};
    case 14: return {0x18, 0, low(at)};
    case 15: return {0x2B, 0x0E, 0x01, 0x00};
    case 16: return {0x15, 11, 6, 0, 4, 0, 7, 0, 2, high(value), low(value), 0xAF, 0xBE};
    case 17: return {kOwnFunction, kKnownCommand, high(value), low(value)};
    default: return fields(8, 0, value);
  }
}

void SerialWire::ask_as_stranger() {
  if (rates_.foreign_every == Duration{0}) {
    return;
  }
  later(rates_.foreign_every, &SerialWire::ask_as_stranger);
  SoakDevice& device = *devices_[around_.random.below(devices_.size())];
  const std::uint8_t address = device.settings().address;
  if (is_busy() || device.is_dead(around_.schedule.now()) || around_.oracle.owes(bus_, address) ||
      talks_until_[address] >= around_.schedule.now() ||
      (asked_until_.contains(address) && asked_until_[address] >= around_.schedule.now())) {
    return;
  }
  around_.report.fault("foreign");
  const modbus::Pdu request = *modbus::Pdu::from(strange_request());
  Frame both = encode(address, request);
  const std::size_t lead = both.size();
  const Frame reply = encode(address, *device.carry_out(request, around_.schedule.now()).answer);
  both.insert(both.end(), reply.begin(), reply.end());
  talks_until_[address] = around_.schedule.now() + timing_.of(both.size());
  // Its request in several pieces, but what follows that answers it.
  const bool is_torn = !ascii_ && happens_to_echo(rates_.pieces, "torn_request");
  say(std::move(both), around_.schedule.now(), is_torn ? Chunks::torn : Chunks::fine,
      {address, 1, 0, true, 0, lead});
}

}  // namespace mbgate::soak
