// SPDX-License-Identifier: Apache-2.0
// Writes, stops and broadcasts.
#include "world/asking.hpp"

namespace mbgate::world {

Intent Asking::write(std::size_t door, bool is_plain) {
  Intent intent = begin(door, Kind::write);
  switch (is_plain ? 0U : random_.between(0U, 16U)) {
    case 4:
    case 5:
    case 6: {
      const unsigned count = random_.between(1U, 10U);
      registers(intent, random_.between(0U, kLiveFrom - count), count);
      break;
    }
    case 7:
      registers(intent, kPairsFrom + 2 * random_.between(0U, 16U), 2 * random_.between(1U, 3U));
      break;
    case 8:
      registers(intent, random_.between(kPairsFrom - 2U, kPairsEnd - 8U), random_.between(1U, 8U));
      break;
    case 9:
      registers(intent, random_.between(kQuadsFrom, kMotionEnd - 8U), random_.between(1U, 8U));
      break;
    case 10:
      single(intent, random_.one_of({random_.between(kPairsFrom, kPairsEnd - 1U),
                                     random_.between(kSlowFrom, kSlowEnd - 1U),
                                     random_.between(kMotionFrom, kCommunicationRegister)}));
      break;
    case 11:
      single(intent, kSilentRegister, 0x7000U | (next(*intent.station, kSilentRegister) & 0xFFFU));
      intent.silent = true;
      break;
    case 12: mask(intent); break;
    case 13: read_and_write(intent); break;
    case 14: coils(intent); break;
    case 15: single(intent, kCommunicationRegister); break;
    case 16: nameless(intent); break;
    default: single(intent, random_.between(0U, kLiveFrom - 1U)); break;
  }
  return intent;
}

void Asking::registers(Intent& intent, unsigned first, unsigned count) {
  Words words;
  for (unsigned at = 0; at < count; ++at) {
    words.push_back(next(*intent.station, first + at));
  }
  plan_write(intent, first, words);
}

// 16, with the words as the drive is to have them.
void Asking::plan_write(Intent& intent, unsigned first, const Words& words) const {
  const Door& door = door_of(intent);
  const auto count = static_cast<unsigned>(words.size());
  const unsigned end = first + count;
  const bool cuts = cuts_value(first) || cuts_value(end);
  const auto at_drive = [&](unsigned address) {
    const bool moves = door.swapped && !cuts;
    return moves ? partner_of(address) : address;
  };
  intent.pdu = request(0x10, first + door.holding_at, count);
  intent.pdu.push_back(low(2 * count));
  for (unsigned at = first; at < end; ++at) {
    append_word(intent.pdu, words[at_drive(at) - first]);
    intent.writes.push_back({Table::holding_registers, at, words[at - first]});
  }
  if (!door.routed) {
    return;
  }
  const drive::Device& device = device_of(intent);
  if (cuts) {
    refuse(intent, code(3));
  }
  const bool has_communication = first <= kCommunicationRegister && end > kCommunicationRegister;
  if (has_communication && !device.allow_reconfigure) {
    refuse(intent, code(1));
  }
  if (!device.split_writes) {
    may_refuse(intent, code(3));
    if (count > device.profile.limits.write_registers && device.write_function != 6) {
      refuse(intent, code(3));
    }
  }
}

void Asking::single(Intent& intent, unsigned address) {
  const unsigned place = door_of(intent).swapped ? partner_of(address) : address;
  single(intent, address, next(*intent.station, place));
}

void Asking::single(Intent& intent, unsigned address, unsigned word) const {
  const Door& door = door_of(intent);
  const unsigned place = door.swapped ? partner_of(address) : address;
  intent.pdu = request(6, address + door.holding_at, word);
  intent.writes.push_back({Table::holding_registers, place, word});
  if (!door.routed) {
    return;
  }
  if (is_motion(address)) {
    refuse(intent, code(3));
  }
  if (address == kCommunicationRegister && !device_of(intent).allow_reconfigure) {
    refuse(intent, code(1));
  }
}

void Asking::mask(Intent& intent) {
  const Door& door = door_of(intent);
  const unsigned address = random_.chance(500) ? random_.between(kPairsFrom, kPairsEnd - 1U)
                                               : random_.between(0U, kLiveFrom - 1U);
  const unsigned place = door.swapped ? partner_of(address) : address;
  const unsigned keep = random_.one_of({0x0000U, 0xFF00U, 0x00F0U});
  const unsigned set = next(*intent.station, kMasks + place);
  intent.pdu = request(0x16, address + door.holding_at, keep);
  append_word(intent.pdu, set);
  intent.writes.push_back({Table::holding_registers, kMasks + place, keep << 16U | set});
}

// Of plain registers: what is read follows what is written (6.17).
void Asking::read_and_write(Intent& intent) {
  const Door& door = door_of(intent);
  const unsigned count = random_.between(1U, 4U);
  const unsigned first = random_.between(0U, kLiveFrom - count);
  const unsigned from = kLiveFrom + random_.below(20U);
  intent.reads = Range{Table::holding_registers, from, 3};
  intent.pdu = request(0x17, from + door.holding_at, 3);
  append_word(intent.pdu, first + door.holding_at);
  append_word(intent.pdu, count);
  intent.pdu.push_back(low(2 * count));
  for (unsigned at = first; at < first + count; ++at) {
    const std::uint16_t word = next(*intent.station, at);
    append_word(intent.pdu, word);
    intent.writes.push_back({Table::holding_registers, at, word});
  }
  may_refuse(intent, code(3));  // over the limit of either half
}

// Each coil is written by one request only: a bit cannot be told from another.
void Asking::coils(Intent& intent) {
  constexpr unsigned kRun = 12;
  const unsigned turn = next(*intent.station, kTableEnd);
  const unsigned first = turn * kRun % (kCoils - kRun - 1U);
  if (turn >= kCoils / kRun) {
    single(intent, 0);
    return;
  }
  if (random_.chance(500)) {
    const bool on = random_.chance(500);
    intent.pdu = request(5, first, on ? 0xFF00 : 0);
    intent.writes.push_back({Table::coils, first, on ? 1U : 0U});
    return;
  }
  const unsigned bits = random_.below(1U << kRun);
  intent.pdu = request(0x0F, first, kRun);
  intent.pdu.insert(intent.pdu.end(), {2, low(bits), high(bits)});
  for (unsigned at = 0; at < kRun; ++at) {
    intent.writes.push_back({Table::coils, first + at, bits >> at & 1U});
  }
}

void Asking::nameless(Intent& intent) {
  const unsigned function = random_.one_of({0x08U, 0x15U, 0x41U, 0x64U});  // two are vendors' own
  const unsigned turn = next(*intent.station, kOpaque + function);
  intent.pdu = function == 0x08 ? request(8, 0, turn) : request(function, turn, 0x1234);
  if (function == 0x15) {
    intent.pdu = {0x15, 9, 6, high(turn), low(turn), 0, 0, 0, 1, 1, 1};
  }
  const std::uint32_t word = std::uint32_t{word_at(intent.pdu, 1)} << 16U | word_at(intent.pdu, 3);
  intent.writes.push_back({Table::holding_registers, kOpaque + function, word});
  if (door_of(intent).windowed) {
    refuse(intent, code(1));
  }
}

Intent Asking::stop(std::size_t door) {
  Intent intent = begin(door, Kind::stop);
  const std::size_t place = *intent.station;
  const unsigned second = 0x5000U | (next(place, kStopRegister) & 0xFFFU);
  const auto word = [](unsigned value) { return static_cast<std::uint16_t>(value); };
  switch (random_.between(0U, 3U)) {
    case 0: {
      const unsigned first = 0x4000U | (next(place, kOtherStop) & 0xFFFU);
      plan_write(intent, kOtherStop, {word(first), word(second)});
      break;
    }
    case 1: plan_write(intent, kStopRegister, {word(second)}); break;
    default: single(intent, kStopRegister, second); break;
  }
  return intent;
}

Intent Asking::broadcast(std::size_t at) {
  Intent intent = begin(at, Kind::broadcast);
  const Door& door = door_of(intent);
  if (!door.route) {
    intent.buses = {static_cast<std::size_t>(*plan_.settings.listeners[door.listener].bus)};
  }
  intent.whole = false;
  const unsigned address =
      random_.one_of({kBroadcastRegister, random_.between(0U, kLiveFrom - 1U)});
  const unsigned word = next(all_of(0), address);
  if (random_.chance(200)) {
    const unsigned stop = 0x5000U | (next(all_of(0), kStopRegister) & 0xFFFU);
    intent.pdu = request(6, kStopRegister, stop);
    intent.writes.push_back({Table::holding_registers, kStopRegister, stop});
  } else {
    intent.pdu = request(6, address, word);
    intent.writes.push_back({Table::holding_registers, address, word});
  }
  may_refuse(intent, code(1) | code(2) | code(3));
  return intent;
}

}  // namespace mbgate::world
