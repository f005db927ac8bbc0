// SPDX-License-Identifier: Apache-2.0
#include "routing/route.hpp"

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

}  // namespace mbgate::routing
