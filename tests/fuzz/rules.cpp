// SPDX-License-Identifier: Apache-2.0
// Any text as the groups and rules of a plant: rules that decide, or errors that say why not.
#include <array>
#include <string>
#include <string_view>

#include "fuzz/fuzz.hpp"
#include "gateway/access/who.hpp"
#include "modbus/request.hpp"
#include "support/config_text.hpp"

namespace mbgate::fuzz::rules_target {
namespace {

constexpr std::string_view kPlant =
    "[[listen]]\nname = \"plant\"\nport = 0\n"
    "[[listen]]\nname = \"service\"\nport = 0\nbus = \"a\"\n"
    "[[bus]]\nname = \"a\"\ndevice = \"/dev/ttyS0\"\n"
    "[[device]]\nname = \"x\"\nbus = \"a\"\naddress = 1\nprofile = \"settable\"\n"
    "[[device]]\nname = \"y\"\nbus = \"a\"\naddress = 2\n"
    "[[route]]\nunit = 1\ndevice = \"x\"\n"
    "[[route]]\nunit = 0\nbus = \"a\"\nbroadcast_mixed = true\n";

/// Every request has an answer, and an address that is refused is refused whatever it asks.
void ask(const gateway::SettingsSnapshot& settings, std::string_view address, unsigned listener) {
  gateway::ClientInfo client;
  client.listener = routing::ListenerId{listener};
  client.address = *routing::ClientAddress::parse(address);
  const auto read = modbus::make_read({modbus::Table::holding_registers, 0x7C, 5});
  const auto write = modbus::make_single_write(modbus::Table::holding_registers, 0x7C, 0xE1);
  bool any_refused = false;
  bool any_let_in = false;
  for (const std::uint8_t unit : std::array<std::uint8_t, 4>{0, 1, 2, 255}) {
    for (const auto& request : {read, write}) {
      const auto answer = gateway::who_may(settings, client, unit, request.pdu());
      require(!answer.by.empty(), "an answer says something");
      require(answer.permitted == answer.by.starts_with("permitted"), "and says what is so");
      require(!answer.permitted || !answer.key, "no key denies what is permitted");
      (answer.by.starts_with("refused") ? any_refused : any_let_in) = true;
    }
  }
  require(any_refused != any_let_in, "a client is let in or not");
}

}  // namespace

MBGATE_FUZZ_TARGET(rules) {
  const std::string text =
      std::string(kPlant) + std::string(reinterpret_cast<const char*>(data), size);
  config::ProfileSearch search;
  search.folder = MBGATE_SOURCE_DIR "/tests/config/profiles";
  const auto loaded = test::load_settings_text("fuzz.toml", text, search);
  require(loaded.settings.has_value() != config::has_errors(loaded.diagnostics),
          "settings, or errors that say why not");
  if (!loaded.settings || loaded.settings->listeners.size() > 4) {
    return 0;
  }
  require(!config::check_summary(*loaded.settings).empty(), "the rules have an end");
  const gateway::SettingsSnapshot settings(*loaded.settings);
  for (const std::string_view address : {"192.168.10.5", "fd00::7"}) {
    ask(settings, address, 0);
    ask(settings, address, 1);
  }
  return 0;
}

}  // namespace mbgate::fuzz::rules_target
