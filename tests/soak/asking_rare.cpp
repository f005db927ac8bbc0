// SPDX-License-Identifier: Apache-2.0
// What looks like something else, and is a write like others: stops among other registers, restarts
// among them, unknown functions, what silences a device. And the longest PDUs.
#include "soak/asking.hpp"
#include "soak/device.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

constexpr unsigned kStopValue = 0x5000;
constexpr unsigned kBootValue = 0x7000;

}  // namespace

bool Asking::writes_one_by_one(const Door& door) const {
  return door.routed && plan_.settings.devices[*door.device].write_function == 6;
}

void Asking::rare(Asked& asked) {
  switch (rare_.between(0U, 9U)) {
    case 0:
    case 1:
    case 2: stop_among_others(asked); break;
    case 3:
    case 4: boot_among_others(asked); break;
    case 5: listen_only(asked); break;
    case 6:
    case 7: unknown_function(asked); break;
    case 8: longest(asked); break;
    default: longest_without_table(asked);
  }
}

// Who writes or reads something else too does not stop, but for the parameters of a stop.
void Asking::stop_among_others(Asked& asked) {
  const auto stop =
      static_cast<std::uint16_t>(kStopValue | next_value(asked, kStopRegister) % 0xFFEU);
  const auto others = static_cast<std::uint16_t>(2 * next_value(asked, kRunOfCoils));
  switch (rare_.between(0U, 5U)) {
    case 0:
    case 1:
      plan_write(asked, kStopRegister - 1U, {next_value(asked, kStopRegister - 1U), stop});
      break;
    case 2: {
      Words words{stop};
      for (unsigned at = 0; at <= device_of(asked).profile.stops.front().parameters; ++at) {
        words.push_back(next_value(asked, kSilentRegister + at));
      }
      plan_write(asked, kStopRegister, words);
      break;
    }
    case 3:
      plan_read_and_write(asked, kStopRegister, {stop}, rare_.between(0U, 20U),
                          rare_.between(1U, 4U));
      break;
    case 4: plan_coils(asked, kStopCoil, {static_cast<std::uint16_t>(others | 1U)}); break;
    default: {
      constexpr unsigned kLast = 0x8000;
      plan_coils(asked, kStopCoil + 1U - kWordOfCoils,
                 {static_cast<std::uint16_t>(others / 2 | kLast)});
    }
  }
}

// Where the registers are written one by one, the drive would boot in the midst of it.
void Asking::boot_among_others(Asked& asked) {
  asked.silent = !writes_one_by_one(*asked.door);
  const std::uint16_t turn = next_value(asked, kSilentRegister);
  const auto boot = static_cast<std::uint16_t>((asked.silent ? kBootValue : 0U) | (turn & 0xFFFU));
  const std::uint16_t before = next_value(asked, kStopRegister);
  const auto free = static_cast<std::uint16_t>(before & 0xFFFU);  // it stops nobody
  const std::uint16_t behind = next_value(asked, kBroadcastRegister);
  switch (rare_.between(0U, 2U)) {
    case 0: plan_write(asked, kStopRegister, {free, boot}); break;
    case 1: plan_write(asked, kSilentRegister, {boot, behind}); break;
    default: plan_write(asked, kStopRegister, {free, boot, behind});
  }
}

bool Asking::may_be_silenced(const Door& door, unsigned sub_function) const {
  if (!door.route) {
    return false;
  }
  const routing::FunctionRules& rules = plan_.settings.routes[*door.route].functions;
  return sub_function == 1 ? rules.restart_communications
                           : sub_function == 4 && rules.force_listen_only;
}

// 08/01 and 08/04, where they are named.
void Asking::listen_only(Asked& asked) {
  const unsigned sub_function = rare_.one_of({1U, 4U});
  asked.pdu = fields(8, sub_function, next_value(asked, kOwnCommand));
  asked.has_no_table = true;
  if (may_be_silenced(*asked.door, sub_function)) {
    asked.silent = true;
    add_whole(asked);
  } else {
    asked.refused = 1;
  }
}

// Some are known by their sub-function, or by none.
void Asking::unknown_function(Asked& asked) {
  const std::uint16_t turn = next_value(asked, kOwnCommand);
  const auto command =
      rare_.one_of({kKnownCommand, kKnownCommand, kRefusedCommand, kUnheardCommand});
  switch (rare_.between(0U, 3U)) {
    case 0: {
      const auto type = rare_.one_of<std::uint8_t>({0x00, 0x0D, 0x0D, 0x0F, 0x8E, 0xFF});
      asked.pdu = {0x2B, type, command, high(turn), low(turn)};
      break;
    }
    case 1:
      asked.pdu =
          fields(8, rare_.one_of({2U, 2U, 10U, 11U, 12U, 13U, 14U, 15U, 16U, 17U, 18U, 20U}), turn);
      break;
    case 2: asked.pdu = {low(0x50U + high(turn) % 0x10U), low(turn)}; break;
    default:
      asked.pdu = {rare_.one_of<std::uint8_t>({0x09, 0x0A, 0x0D, 0x0E, 0x12, 0x13, 0x19, 0x28, 0x2A,
                                               0x2C, 0x42, 0x48, 0x64, 0x6E, 0x7F}),
                   command, high(turn), low(turn)};
  }
  asked.has_no_table = true;
  add_whole(asked);
}

// As many coils and registers as one request may name. Not all devices have so many.
void Asking::longest(Asked& asked) {
  constexpr unsigned kCoilWords = 1968 / kWordOfCoils;
  constexpr unsigned kWritten = 123;
  constexpr unsigned kWrittenBeside = 121;
  constexpr unsigned kRead = 125;
  const auto words = [&](unsigned first, unsigned count) {
    Words values;
    for (unsigned at = 0; at < count; ++at) {
      values.push_back(next_value(asked, first + at));
    }
    return values;
  };
  const drive::Limits& limits = device_of(asked).profile.limits;
  const bool is_limited = limits.write_registers < kWritten || writes_one_by_one(*asked.door);
  if (asked.door->routed && is_limited) {
    longest_without_table(asked);
    return;
  }
  const unsigned kind = rare_.between(0U, 2U);
  if (kind == 0 && !asked.door->routed) {
    plan_coils(asked, kFirstRunOfCoils,
               Words(kCoilWords, scattered(next_value(asked, kRunOfCoils))));
  } else if (kind == 1) {
    const unsigned first = rare_.between(0U, kStopRegister - kWritten);
    plan_write(asked, first, words(first, kWritten));
  } else {
    const unsigned first = rare_.between(0U, kStopRegister - kWrittenBeside);
    plan_read_and_write(asked, first, words(first, kWrittenBeside),
                        rare_.between(0U, kRegisters - kRead), kRead);
  }
}

void Asking::longest_without_table(Asked& asked) {
  const std::uint16_t turn = next_value(asked, kOwnCommand);
  switch (rare_.between(0U, 3U)) {
    case 0: asked.pdu = fields(8, 0, turn); break;
    case 1: {
      constexpr unsigned kRegistersOfRecord = 122;
      asked.pdu = {0x15, low(spec::kLongestPdu - 2), 6, 0, 4, 0, 7, 0, low(kRegistersOfRecord)};
      append_word(asked.pdu, turn);
      break;
    }
    case 2: asked.pdu = {0x2B, 0x0D, kKnownCommand, high(turn), low(turn)}; break;
    default: asked.pdu = {kOwnFunction, kKnownCommand, high(turn), low(turn)};
  }
  const std::size_t size = spec::kLongestPdu - (asked.pdu[0] == kOwnFunction ? turn % 2U : 0U);
  while (asked.pdu.size() < size) {
    asked.pdu.push_back(static_cast<std::uint8_t>(rare_.below(256)));
  }
  asked.has_no_table = true;
  add_whole(asked);
}

}  // namespace mbgate::soak
