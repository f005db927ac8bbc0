// SPDX-License-Identifier: Apache-2.0
// Any text as a drive profile: a profile that requests can be planned with, or diagnostics.
#include <array>
#include <string>

#include "config/profiles/profile_file.hpp"
#include "fuzz/fuzz.hpp"
#include "modbus/request.hpp"
#include "routing/plan.hpp"

namespace mbgate::fuzz::profile_target {
namespace {

void plan(const drive::Device& device, drive::WordOrder seen, const modbus::Request& request) {
  routing::ResolvedRoute resolved;
  resolved.device = &device;
  resolved.route.first_unit = resolved.route.last_unit = resolved.route.first_address = 1;
  resolved.route.buses = {device.bus};
  resolved.route.word_order = seen;
  const auto planned = routing::Plan::make(resolved, 1, {}, request.pdu());
  require(!planned || !planned->transactions().empty(), "a plan does something");
}

/// Reads and writes of the value, whole and in part.
void use(const drive::Device& device, const drive::Value& value) {
  constexpr std::array<std::uint8_t, 8> kData{1, 2, 3, 4, 5, 6, 7, 8};
  for (const auto seen : {drive::WordOrder::big, drive::WordOrder::little}) {
    plan(device, seen, modbus::make_read({value.table, value.first, 1}));
    plan(device, seen, modbus::make_read(value.range()));
    if (value.table == modbus::Table::holding_registers) {
      plan(device, seen, modbus::make_single_write(value.table, value.first, 1));
      plan(device, seen,
           modbus::make_multiple_write(
               value.range(), modbus::Bytes(kData).first(value.registers * std::size_t{2})));
    }
  }
}

}  // namespace

MBGATE_FUZZ_TARGET(profile) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto loaded = config::load_profile(config::TextFile{"fuzz.toml", text});
  require(loaded.file.has_value() != config::has_errors(loaded.diagnostics),
          "a profile, or errors that say why not");
  require(config::render(loaded.diagnostics).empty() == loaded.diagnostics.empty(),
          "every diagnostic says something");
  if (loaded.file) {
    drive::Device device;
    device.profile = loaded.file->profile;
    device.word_order = device.profile.word_order.value_or(drive::WordOrder::little);
    device.write_function = device.profile.write_function;
    for (const auto& value : device.profile.values.all()) {
      use(device, value);
    }
  }
  return 0;
}

}  // namespace mbgate::fuzz::profile_target
