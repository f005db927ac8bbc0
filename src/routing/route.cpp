// SPDX-License-Identifier: Apache-2.0
#include "routing/route.hpp"

#include <algorithm>
#include <cstdint>

#include "modbus/codes.hpp"

namespace mbgate::routing {
namespace {

/// Does a request with this function move something? Unknown functions may; diagnostics and
/// identification (08, 43) do not, though they are no reads in every form.
bool may_move(std::uint8_t function) {
  return modbus::is_request_function(function) && !modbus::is_read({&function, 1}) &&
         function != static_cast<std::uint8_t>(modbus::FunctionCode::diagnostics) &&
         function != static_cast<std::uint8_t>(modbus::FunctionCode::encapsulated_interface);
}

}  // namespace

FunctionRules FunctionRules::all() {
  FunctionRules rules;
  rules.allowed.set();
  rules.allowed.reset(0);
  return rules;
}

FunctionRules FunctionRules::rewritable() {
  FunctionRules rules;
  for (const std::size_t function : {1U, 2U, 3U, 4U, 5U, 6U, 15U, 16U, 22U, 23U, 24U}) {
    rules.allowed.set(function);
  }
  return rules;
}

bool Route::may_write() const {
  if (access == Access::read_only) {
    return false;
  }
  for (std::uint8_t function = 0; function < functions.allowed.size(); ++function) {
    if (functions.allowed.test(function) && may_move(function)) {
      return true;
    }
  }
  return false;
}

bool Route::leads_to(const drive::Device& server) const {
  if (is_broadcast()) {
    return std::ranges::find(buses, server.bus) != buses.end();
  }
  return buses.front() == server.bus &&
         (server.has_every_unit || (server.address >= first_address &&
                                    server.address - first_address <= last_unit - first_unit));
}

}  // namespace mbgate::routing
