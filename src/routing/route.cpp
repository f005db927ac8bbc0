// SPDX-License-Identifier: Apache-2.0
#include "routing/route.hpp"

#include <algorithm>
#include <array>

namespace mbgate::routing {

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
  constexpr std::array kWriting{0x05U, 0x06U, 0x0FU, 0x10U, 0x16U, 0x17U};
  return access == Access::read_write && std::ranges::any_of(kWriting, [this](unsigned function) {
           return functions.allowed.test(function);
         });
}

bool Route::leads_to(const drive::Device& server) const {
  if (is_broadcast()) {
    return std::ranges::find(buses, server.bus) != buses.end();
  }
  return buses.front() == server.bus && server.address >= first_address &&
         server.address - first_address <= last_unit - first_unit;
}

}  // namespace mbgate::routing
