// SPDX-License-Identifier: Apache-2.0
// What is for all: who hears it, in which forms it goes out, and what must not be said to all at
// once.
#include <algorithm>
#include <ranges>

#include "soak/asking.hpp"
#include "soak/pdus.hpp"
#include "soak/specification.hpp"

namespace mbgate::soak {
namespace {

using drive::Device;
using drive::WordOrder;

constexpr unsigned kOdd = 350;             // permille of broadcasts
constexpr std::uint16_t kMarked = 0x8000;  // in words that only broadcasts write

bool is_autonics(const Device& device) {
  return device.profile.broadcast.form == drive::BroadcastForm::autonics;
}

bool is_within(const spec::Range& range, unsigned first, unsigned end) {
  return range.first >= first && range.first + range.count <= end;
}

// What the AiC's manual lists; of registers so many at once.
bool is_for_autonics(const PduBytes& pdu, const spec::Range& range) {
  if (range.table == Table::coils) {
    return is_within(range, kStopCoil, kCoils);
  }
  return (is_within(range, kStopRegister, kStopRegister + 3U) ||
          is_within(range, kBroadcastRun, kBroadcastRun + kMostOfBroadcastRun) ||
          is_within(range, kValueOfSome, kValueOfSome + 2U)) &&
         (pdu[0] != 0x10 || range.count <= kMostOfAutonics);
}

// Why a drive must not be told so.
std::optional<std::uint8_t> objection(const Device& device, const spec::Range& range) {
  const drive::Limits& limits = device.profile.limits;
  if (range.table == Table::coils) {
    return range.count > limits.write_coils ? std::optional<std::uint8_t>(3) : std::nullopt;
  }
  const unsigned end = range.first + range.count;
  if (range.first <= kCommunicationRegister && end > kCommunicationRegister &&
      !device.allow_reconfigure) {
    return 1;
  }
  const bool fits = range.count <= limits.write_registers && !cuts_any(range.first, end);
  return fits ? std::nullopt : std::optional<std::uint8_t>(3);
}

// The position behind an opcode, as a client sees it.
enum class Position : std::uint8_t { as_it_is, exchanged, uncertain };

// `seen`: what its client wants to see, if it names an order.
Position position_for(const Device& device, const WordOrder* seen) {
  if (seen == nullptr || *seen == device.opcode_order.value_or(*device.word_order)) {
    return Position::as_it_is;
  }
  return device.opcode_order ? Position::exchanged : Position::uncertain;
}

}  // namespace

Asked Asking::broadcast(const Door& door) {
  Asked asked = begin(door, Kind::broadcast);
  asked.replies = door.replies;
  asked.stops_all = random_.chance(400) && !door.only_autonics && !door.is_closed;
  ++broadcasts_;
  if (!asked.stops_all && forms_.chance(kOdd)) {
    pick_odd(asked);
  } else {
    pick_broadcast(asked);
  }
  pick_boot(asked);
  pick_peculiar(asked);
  const bool may_be_for_all =
      asked.pdu[0] == 5 || asked.pdu[0] == 6 || asked.pdu[0] == 0x0F || asked.pdu[0] == 0x10;
  if (door.is_closed) {
    asked.refused = 0x0A;
  } else if (may_only_read_ || door.read_only || !may_be_for_all) {
    asked.refused = 1;
  } else {
    const Receivers receivers = add_forms(asked);
    exchange_for(asked, receivers);
    exchange_peculiar(asked, receivers);
  }
  if (asked.refused) {
    asked.stops_all = false;
    asked.pieces.clear();
  }
  return asked;
}

// Drives of a bus that listen at address 0, or at that of the Autonics form.
Asking::Receivers Asking::listeners(std::size_t bus, bool autonics) const {
  Receivers listening;
  for (std::size_t index = 0; index < plan_.settings.devices.size(); ++index) {
    const Device& device = plan_.settings.devices[index];
    if (static_cast<std::size_t>(device.bus) == bus && !plan_.absent.devices[index] &&
        is_autonics(device) == autonics) {
      listening.push_back(&device);
    }
  }
  return listening;
}

// Who hears it, bus by bus, first those at address 0. Those who listen there cannot be kept from
// it.
Asking::Receivers Asking::add_forms(Asked& asked) const {
  Receivers receivers;
  const spec::Range range = *spec::fields_of(asked.pdu)->writes;
  for (const std::size_t bus : asked.door->buses) {
    for (const bool autonics : {false, true}) {
      if (autonics ? !is_for_autonics(asked.pdu, range) : asked.door->only_autonics) {
        continue;
      }
      const Receivers listening = listeners(bus, autonics);
      if (!listening.empty()) {
        receivers.insert(receivers.end(), listening.begin(), listening.end());
        PduBytes pdu = asked.pdu;
        pdu[0] = static_cast<std::uint8_t>(pdu[0] | (autonics ? 0x80U : 0U));
        const std::uint8_t address = autonics ? kAutonicsAddress : 0;
        asked.pieces.push_back({bus, address, std::move(pdu), 0, false, false});
      }
    }
  }
  return receivers;
}

// In one order, as far as is known.
bool Asking::speak_alike(const Receivers& receivers) {
  const auto& order = receivers.front()->word_order;
  return (order || receivers.size() == 1) &&
         std::ranges::all_of(receivers, [&](const Device* it) { return it->word_order == order; });
}

// None if its clients name none.
const WordOrder* Asking::order_seen(const Door& door) const {
  return door.names_order ? &*plan_.settings.routes[*door.route].word_order : nullptr;
}

// What drives get is worked out by now; this is what their client must have written for it, or why
// nobody gets it.
void Asking::exchange_for(Asked& asked, const Receivers& receivers) const {
  if (receivers.empty()) {
    asked.refused = 2;
    return;
  }
  const spec::Fields fields = *spec::fields_of(asked.pdu);
  const spec::Range& range = *fields.writes;
  for (const Device* device : receivers) {
    asked.refused = asked.refused ? asked.refused : objection(*device, range);
  }
  if (asked.refused || range.table == Table::coils) {
    return;
  }
  const WordOrder* seen = order_seen(*asked.door);
  const Device& first = *receivers.front();
  const auto all = [&](const auto& are_alike) { return std::ranges::all_of(receivers, are_alike); };
  const unsigned end = range.first + range.count;
  if (touches_value(range.first, end)) {
    if (!speak_alike(receivers)) {
      asked.refused = 3;
    } else if (seen != nullptr && *seen != *first.word_order) {
      asked.pdu = multiple_pdu(range.first, exchanged(fields.words, range.first));
    }
  } else if (range.first == kOpcodeRegister && fields.words.front() == kPositionOpcode) {
    const Position position = position_for(first, seen);
    if (position == Position::uncertain ||
        !all([&](const Device* it) { return position_for(*it, seen) == position; })) {
      asked.refused = 3;
    } else if (position == Position::exchanged) {
      asked.pdu = multiple_pdu(range.first, {fields.words[0], fields.words[2], fields.words[1]});
    }
  }
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

// All boot who hear it.
void Asking::pick_boot(Asked& asked) {
  constexpr unsigned kSome = 150;
  const unsigned value = 0x7000U | (broadcasts_ & 0xFFFU);
  if (!boots_.chance(kSome) || asked.stops_all) {
    return;
  }
  asked.pdu = boots_.chance(500)
                  ? fields(6, kSilentRegister, value)
                  : multiple_pdu(kSilentRegister, {static_cast<std::uint16_t>(value)});
}

// Values, opcodes, runs that are too long for some, what changes how drives communicate, and what
// cannot be said to all.
void Asking::pick_odd(Asked& asked) {
  const auto marked = [&](unsigned count) {
    Words words;
    for (unsigned at = 0; at < count; ++at) {
      words.push_back(static_cast<std::uint16_t>(kMarked + broadcasts_ % 0x400U * 0x20U + at));
    }
    return words;
  };
  const auto run = [&](unsigned first, unsigned count) {
    asked.pdu = multiple_pdu(first, marked(count));
  };
  const auto one = [&](unsigned address) { asked.pdu = fields(6, address, marked(1).front()); };
  switch (forms_.between(0U, 12U)) {
    case 0:
    case 1: {
      const unsigned pairs = forms_.between(1U, 3U);
      run(kPairsFrom + 2 * forms_.between(0U, 20U - pairs), 2 * pairs);
      break;
    }
    case 2: run(kQuadsFrom + 4 * forms_.between(0U, 2U), 4); break;
    case 3: run(kMotionFrom, 2); break;
    case 4: run(kPairsFrom + 1U + forms_.between(0U, 20U), forms_.between(2U, 3U)); break;
    case 5: one(kPairsFrom + forms_.between(0U, 20U)); break;
    case 6: one(kCommunicationRegister); break;
    case 7: run(forms_.between(0U, 20U), forms_.between(4U, 12U)); break;
    case 8: {
      const Words words(forms_.between(1U, 8U), scattered(broadcasts_));
      asked.pdu = coils_pdu(kFirstRunOfCoils + forms_.between(0U, 100U), words);
      break;
    }
    case 9: {
      constexpr unsigned kSingles = kCoils - kBroadcastCoil;
      const unsigned turn = broadcasts_ % (2 * kSingles);
      asked.pdu = fields(5, kBroadcastCoil + turn % kSingles, turn < kSingles ? kOn : 0);
      break;
    }
    case 10: {
      Words words = marked(3);
      words[0] = kPositionOpcode;
      asked.pdu = multiple_pdu(kOpcodeRegister, words);
      break;
    }
    case 11: asked.pdu = fields(forms_.between(1U, 4U), 0, 1); break;
    default: asked.pdu = {0x16, 0, 1, 0, 0, 0, 1};
  }
  const auto written = spec::fields_of(asked.pdu)->writes;
  const bool may_be_asked_first = asked.door->names_order && verifies(*asked.door);
  if (may_be_asked_first && written && written->table == Table::holding_registers &&
      touches_value(written->first, written->first + written->count)) {
    one(forms_.between(0U, 20U));
  }
}

// Else address 129 is a device like others.
bool Asking::hears_autonics(const Door& door) const {
  const auto all = std::views::iota(std::size_t{0}, plan_.settings.devices.size());
  return std::ranges::any_of(all, [&](std::size_t index) {
    const Device& device = plan_.settings.devices[index];
    return static_cast<std::size_t>(device.bus) == door.buses.front() && is_autonics(device) &&
           !plan_.absent.devices[index];
  });
}

// Is a drive there that is asked for its word order before values are written?
bool Asking::verifies(const Door& door) const {
  return std::ranges::any_of(plan_.settings.devices, [&](const Device& device) {
    return device.verify_word_order &&
           std::ranges::find(door.buses, static_cast<std::size_t>(device.bus)) != door.buses.end();
  });
}

}  // namespace mbgate::soak
