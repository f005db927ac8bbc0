// SPDX-License-Identifier: Apache-2.0
// What parts of the gateway need to be tried without it: settings, and clients of their own.
#pragma once

#include "gateway/clients/intake.hpp"
#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {

using gateway::ActionQueue;
using gateway::ClientInfo;
using gateway::ClientSession;
using gateway::SettingsHistory;

inline ClientInfo info_of(std::string_view address, std::uint32_t listener = 0) {
  return {ListenerId{listener}, *routing::ClientAddress::parse(address)};
}

template <typename Kind>
std::vector<Kind> reports(ActionQueue& actions) {
  std::vector<Kind> found;
  while (const auto action = actions.poll()) {
    const auto* report = std::get_if<gateway::Report>(&*action);
    if (const auto* kind = report == nullptr ? nullptr : std::get_if<Kind>(&report->event)) {
      found.push_back(*kind);
    }
  }
  return found;
}

}  // namespace mbgate::test
