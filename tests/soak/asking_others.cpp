// SPDX-License-Identifier: Apache-2.0
// Coils, functions that name no table, stops, and what is for all.
#include <algorithm>

#include "soak/asking.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

constexpr unsigned kWordOfCoils = 16;
constexpr unsigned kOn = 0xFF00;

/// No window shows coils.
bool is_outside(Asked& asked) {
  const bool outside = asked.door->windowed && !asked.door->shows_coils;
  if (outside) {
    asked.refused = 2;
  }
  return outside;
}

std::uint16_t scattered(std::uint16_t counter) {
  constexpr unsigned kOdd = 40503;  // so that no two are alike
  return static_cast<std::uint16_t>(counter * kOdd);
}

PduBytes coils_pdu(unsigned first, const Words& words) {
  PduBytes pdu = fields(0x0F, first, static_cast<unsigned>(words.size()) * kWordOfCoils);
  pdu.push_back(low(static_cast<unsigned>(words.size() * 2)));
  for (const std::uint16_t word : words) {
    pdu.push_back(low(word));  // the first coil is the lowest bit of the first byte
    pdu.push_back(high(word));
  }
  return pdu;
}

PduBytes one_of_coils(unsigned address) { return {0x0F, high(address), low(address), 0, 1, 1, 1}; }

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
  const unsigned first = random_.between<unsigned>(kFirstRunOfCoils, kRunsOfCoilsEnd - count);
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
Asked Asking::stop(const Door& door) {
  if (door.read_only || may_only_read_) {
    return read(door, false);
  }
  Asked asked = begin(door, Kind::stop);
  asked.is_repeated = true;
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
  if (form < 4) {
    plan_write(asked, kStopRegister, {value});
  } else {
    single(asked, kStopRegister, value);
  }
  return asked;
}

Asked Asking::broadcast(const Door& door) {
  Asked asked = begin(door, Kind::broadcast);
  asked.replies = door.replies;
  asked.stops_all = random_.chance(400);
  ++broadcasts_;
  pick_broadcast(asked);
  for (const std::size_t bus : door.buses) {
    bool any_standard = false;
    bool any_autonics = false;
    for (std::size_t index = 0; index < plan_.settings.devices.size(); ++index) {
      const drive::Device& device = plan_.settings.devices[index];
      if (static_cast<std::size_t>(device.bus) == bus && !plan_.absent.devices[index]) {
        const bool is_aic = device.profile.broadcast.form == drive::BroadcastForm::autonics;
        any_standard = any_standard || !is_aic;
        any_autonics = any_autonics || is_aic;
      }
    }
    if (any_standard) {
      asked.pieces.push_back({bus, 0, asked.pdu, 0, false, false});
    }
    // Of registers its manual allows so many at once.
    if (any_autonics && !(asked.pdu[0] == 0x10 && asked.pdu[4] > kMostOfAutonics)) {
      PduBytes pdu = asked.pdu;
      pdu[0] = static_cast<std::uint8_t>(pdu[0] | 0x80U);
      asked.pieces.push_back({bus, kAutonicsAddress, std::move(pdu), 0, false, false});
    }
  }
  if (may_only_read_ || asked.pieces.empty()) {
    asked.refused = may_only_read_ ? 1 : 2;
    asked.stops_all = false;
    asked.pieces.clear();
  }
  return asked;
}

// Of those that get no reply nobody could tell when each has ended: no two of them are alike.
void Asking::pick_broadcast(Asked& asked) {
  const bool may_repeat = asked.door->replies;
  if (asked.stops_all) {
    if (may_repeat && random_.chance(200)) {
      asked.is_shared = true;
      asked.pdu = random_.chance(500) ? fields(5, kStopCoil, kOn) : one_of_coils(kStopCoil);
      return;
    }
    asked.is_shared = may_repeat && random_.chance(300);
    const unsigned value = 0x5000U | (asked.is_shared ? 0xFFFU : broadcasts_ % 0xFFEU);
    asked.pdu = random_.chance(300)
                    ? multiple_pdu(kStopRegister, {static_cast<std::uint16_t>(value)})
                    : fields(6, kStopRegister, value);
    return;
  }
  switch (random_.between(0U, 5U)) {
    case 0: asked.pdu = coils_pdu(kBroadcastCoils, {scattered(broadcasts_)}); return;
    case 1:
    case 2: {
      Words words(random_.between<unsigned>(1U, kMostOfBroadcastRun), broadcasts_);
      asked.pdu = multiple_pdu(kBroadcastRun, words);
      return;
    }
    default: asked.pdu = fields(6, kBroadcastRegister, broadcasts_);
  }
}

}  // namespace mbgate::soak
