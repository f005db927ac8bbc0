// SPDX-License-Identifier: Apache-2.0
// The whole machine, driven by a script: clients and lines do what they like, time passes.
#include "fuzz/driver.hpp"
#include "fuzz/plant_change.hpp"
#include "fuzz/responses.hpp"

namespace mbgate::fuzz::machine_target {
namespace {

using Adu = std::vector<std::uint8_t>;

/// Requests that mean something to the plant's drives, with small addresses and quantities.
Adu request_of(Script& script, std::uint16_t transaction) {
  const std::uint8_t unit = script.byte() % 8;
  const std::uint8_t address = script.byte();
  const std::uint8_t low = script.byte();
  Adu pdu;
  switch (script.byte() % 8) {
    case 0: pdu = {0x06, 0x00, 0x7C, 0x00, 0xE1}; break;  // a stop
    case 1: pdu = {0x06, 0x00, 0x80, 0x00, low}; break;   // a restart
    case 2: pdu = {0x06, 0x00, address, 0x00, low}; break;
    case 3: pdu = {0x10, 0x00, address, 0x00, 0x02, 0x04, 0x00, low, 0x00, 0x01}; break;
    case 4: pdu = {0x01, 0x00, address, 0x00, static_cast<std::uint8_t>(1 + low % 64)}; break;
    case 5: pdu = {0x17, 0x00, address, 0x00, 0x02, 0x00, 0x10, 0x00, 0x01, 0x02, 0x00, low}; break;
    case 6: pdu = {0x2B, 0x0E, 0x01, 0x00}; break;
    default:
      pdu = {0x03, 0x00, static_cast<std::uint8_t>(address % 32), 0x00,
             static_cast<std::uint8_t>(1 + low % 32)};
  }
  Adu adu{static_cast<std::uint8_t>(transaction >> 8U),
          static_cast<std::uint8_t>(transaction & 0xFFU),
          0,
          0,
          0,
          static_cast<std::uint8_t>(pdu.size() + 1),
          unit == 7 ? std::uint8_t{255} : unit};
  adu.insert(adu.end(), pdu.begin(), pdu.end());
  return adu;
}

/// The parts of a frame that the line has heard.
std::optional<modbus::RtuAdu> parts_of(bus::Framing framing, modbus::Bytes frame) {
  switch (framing) {
    case bus::Framing::rtu: return modbus::decode_rtu(frame);
    case bus::Framing::ascii: return modbus::decode_ascii(frame);
    case bus::Framing::tcp: break;
  }
  const auto scan = modbus::scan_mbap(frame);
  const auto* adu = std::get_if<modbus::MbapFrame>(&scan);
  return adu == nullptr ? std::nullopt
                        : std::optional(modbus::RtuAdu{adu->adu.header.unit, adu->adu.pdu});
}

Adu frame_of(bus::Framing framing, const modbus::RtuAdu& adu, modbus::Bytes asked) {
  const auto list = [](const auto& bytes) { return Adu(bytes.begin(), bytes.end()); };
  switch (framing) {
    case bus::Framing::rtu: return list(modbus::encode_rtu(adu.address, adu.pdu));
    case bus::Framing::ascii: return list(modbus::encode_ascii(adu.address, adu.pdu));
    case bus::Framing::tcp: break;
  }
  return list(modbus::encode(modbus::MbapAdu{{modbus::load_be16(asked, 0), adu.address}, adu.pdu}));
}

/// A device answers what was heard last, perhaps late, perhaps with one byte changed.
void answer(Driver& driver, Script& script) {
  const std::size_t bus = script.byte() % driver.buses();
  const bus::FrameBytes heard = driver.heard(bus);
  const std::uint8_t damage = script.byte();
  const auto asked = parts_of(driver.framing(bus), {heard.data(), heard.size()});
  const auto request =
      asked
          ? modbus::Request::parse(asked->pdu)
          : Result<modbus::Request, modbus::ExceptionCode>(modbus::ExceptionCode::illegal_function);
  if (!request) {
    return;
  }
  Adu frame = frame_of(driver.framing(bus), {asked->address, response_to(*request, script)},
                       {heard.data(), heard.size()});
  if (damage >= 0xC0) {
    frame[damage % frame.size()] ^= static_cast<std::uint8_t>(1U + script.byte() % 255U);
  }
  if (driver.framing(bus) != bus::Framing::tcp && (damage & 1U) != 0) {
    Adu echoed(heard.begin(), heard.end());
    echoed.insert(echoed.end(), frame.begin(), frame.end());
    frame = echoed;
  }
  driver.line_bytes(bus, frame);
}

/// Which plant is in force.
struct Rules {
  std::uint16_t choices = 0;
  std::uint16_t change = 0;
};

/// Settings as often as they like: the same ones, moved, or others.
void reload(Driver& driver, Script& script, bool other_choices, Rules& rules) {
  const std::uint16_t change = script.word();
  const std::uint16_t choices = other_choices ? script.word() : rules.choices;
  const bool is_same =
      choices == rules.choices && ((change ^ rules.change) & kMeaningOfChange) == 0;
  rules = {choices, change};
  driver.reload(changed(plant(choices), change), is_same);
}

/// What happens to the gateway as a whole.
void outer_step(Driver& driver, Script& script, Rules& rules) {
  const std::uint8_t choice = script.byte();
  if (choice == 0xFF) {
    driver.shutdown();
  } else if (choice >= 0x80) {
    driver.set_slow(choice % driver.buses(), choice >= 0xC0);
  } else if (choice >= 0x40) {
    reload(driver, script, choice >= 0x60, rules);
  } else if (choice >= 0x10) {
    driver.stall(std::chrono::milliseconds(100) * choice);
  } else {
    driver.clear_counters();
  }
}

void step(Driver& driver, Script& script, Rules& rules, std::uint16_t& transaction) {
  const std::uint8_t kind = script.byte() % 16;
  const std::size_t who = kind >= 1 && kind <= 8 ? script.byte() % 8U : 0U;
  switch (kind) {
    case 0: {
      const std::uint8_t choice = script.byte();
      driver.connect(static_cast<std::uint32_t>(choice % driver.listeners()), (choice >> 2U) % 4,
                     choice >= 0xE0);
      return;
    }
    case 1:
    case 2:
    case 3: driver.client_bytes(who, request_of(script, transaction++)); return;
    case 4: driver.client_bytes(who, script.piece()); return;
    case 5: driver.half_close(who); return;
    case 6: driver.disconnect(who); return;
    case 7:
    case 8: driver.confirm(who); return;
    case 9:
    case 10: answer(driver, script); return;
    case 11: {
      const std::size_t bus = script.byte() % driver.buses();
      driver.line_bytes(bus, script.piece());
      return;
    }
    case 12: {
      const std::uint8_t choice = script.byte();
      driver.set_present(choice % driver.buses(), choice < 0x80);
      driver.lose(choice % driver.buses());
      return;
    }
    case 13: driver.advance(std::chrono::microseconds(100) * script.byte()); return;
    case 14: driver.advance(std::chrono::milliseconds(20) * script.byte()); return;
    default: outer_step(driver, script, rules);
  }
}

}  // namespace

MBGATE_FUZZ_TARGET(machine) {
  Script script(data, size);
  Rules rules{script.word(), 0};
  Driver driver(plant(rules.choices));
  for (std::uint8_t clients = 0; clients < 3; ++clients) {
    driver.connect(clients % 2U, clients, false);
  }
  std::uint16_t transaction = 0;
  while (!script.empty()) {
    step(driver, script, rules, transaction);
  }
  driver.finish();
  return 0;
}

}  // namespace mbgate::fuzz::machine_target
