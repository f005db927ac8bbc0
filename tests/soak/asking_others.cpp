// SPDX-License-Identifier: Apache-2.0
// Coils, functions that name no table, and stops.
#include <algorithm>

#include "soak/asking.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

/// No window shows coils.
bool is_outside(Asked& asked) {
  const bool outside = asked.door->windowed && !asked.door->shows_coils;
  if (outside) {
    asked.refused = 2;
  }
  return outside;
}

}  // namespace

// Each coil in its turn, on the first round and off the next: no two that are open are alike.
void Asking::coil(Asked& asked) {
  const unsigned turn = next_value(asked, kCoil);
  const unsigned address = turn % kFirstRunOfCoils;
  const unsigned value = (turn / kFirstRunOfCoils) % 2 == 0 ? kOn : 0;
  asked.pdu = fields(5, address + asked.door->coils_at, value);
  if (!is_outside(asked)) {
    add_piece(asked, fields(5, address, value));
  }
}

void Asking::coils(Asked& asked) {
  Words words(random_.between(1U, 8U));
  for (std::uint16_t& word : words) {
    word = scattered(next_value(asked, kRunOfCoils));
  }
  const auto count = static_cast<unsigned>(words.size()) * kWordOfCoils;
  plan_coils(asked, random_.between<unsigned>(kFirstRunOfCoils, kRunsOfCoilsEnd - count), words);
}

void Asking::plan_coils(Asked& asked, unsigned first, const Words& words) const {
  const auto count = static_cast<unsigned>(words.size()) * kWordOfCoils;
  asked.pdu = coils_pdu(first + asked.door->coils_at, words);
  if (is_outside(asked)) {
    return;
  }
  const drive::Device& device = device_of(asked);
  const unsigned limit = asked.door->routed ? device.profile.limits.write_coils : 1968U;
  if (count > limit && !device.split_writes) {
    asked.refused = 3;
    return;
  }
  const std::size_t most = limit / kWordOfCoils;
  for (std::size_t at = 0; at < words.size(); at += most) {
    const std::size_t end = std::min(words.size(), at + most);
    add_piece(asked, coils_pdu(first + static_cast<unsigned>(at) * kWordOfCoils,
                               {words.begin() + static_cast<std::ptrdiff_t>(at),
                                words.begin() + static_cast<std::ptrdiff_t>(end)}));
  }
}

// The device repeats it or does not know it; how long the answer is nobody knows before.
void Asking::own_function(Asked& asked) {
  const std::uint16_t turn = next_value(asked, kOwnCommand);
  const std::uint8_t command =
      random_.chance(800) ? kKnownCommand : static_cast<std::uint8_t>(kKnownCommand + 1);
  asked.pdu = {kOwnFunction, command, high(turn), low(turn)};
  for (unsigned count = random_.between(0U, 40U); count > 0; --count) {
    asked.pdu.push_back(static_cast<std::uint8_t>(random_.below(256)));
  }
  asked.has_no_table = true;
  add_whole(asked);
}

// 21: one group of two registers.
void Asking::file_record(Asked& asked) {
  const std::uint16_t turn = next_value(asked, kOwnCommand);
  asked.pdu = {0x15, 11, 6, 0, 4, 0, 7, 0, 2, high(turn), low(turn), 0xAF, 0xBE};
  asked.has_no_table = true;
  add_whole(asked);
}

// 08/00: the data comes back.
void Asking::diagnostics(Asked& asked) {
  asked.pdu = fields(8, 0, next_value(asked, kOwnCommand));
  asked.has_no_table = true;
  add_whole(asked);
}

// No window can rewrite it.
void Asking::add_whole(Asked& asked) const {
  if (asked.door->windowed) {
    asked.refused = 1;
  } else {
    add_piece(asked, asked.pdu);
  }
}

// By a register or a coil. Those of a coil are all alike, and so are some of the others.
Asked Asking::stop(const Door& door, bool are_alike) {
  if (door.read_only || may_only_read_) {
    return read(door, false);
  }
  Asked asked = begin(door, Kind::stop);
  asked.is_repeated = true;
  if (are_alike) {
    asked.is_shared = true;
    single(asked, kStopRegister, 0x5FFF);
    return asked;
  }
  const unsigned form = random_.between(0U, 9U);
  if (form < 2 && door.shows_coils) {
    const auto pdu = [&](unsigned at) { return form == 0 ? fields(5, at, kOn) : one_of_coils(at); };
    asked.is_shared = true;
    asked.pdu = pdu(kStopCoil + door.coils_at);
    add_piece(asked, pdu(kStopCoil));
    return asked;
  }
  asked.is_shared = random_.chance(300);
  const auto value = static_cast<std::uint16_t>(
      0x5000U | (asked.is_shared ? 0xFFFU : next_value(asked, kStopRegister) % 0xFFEU));
  if (form < 3 && !writes_one_by_one(door) &&
      device_of(asked).profile.stops.front().parameters > 0) {
    plan_write(asked, kStopRegister, {value, 1});
  } else if (form < 4) {
    plan_write(asked, kStopRegister, {value});
  } else {
    single(asked, kStopRegister, value);
  }
  return asked;
}

}  // namespace mbgate::soak
