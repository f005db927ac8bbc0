// SPDX-License-Identifier: Apache-2.0
// The text forms of actions.
#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "gateway/action.hpp"
#include "modbus/describe.hpp"
#include "report/text.hpp"

namespace mbgate::test {

struct ActionText {
  const gateway::Settings& settings;

  std::string operator()(const gateway::Send& a) const {
    return client(a.client) + " < " +
           modbus::describe_mbap({a.adu.data(), a.adu.size()}, modbus::Direction::response);
  }
  std::string operator()(const gateway::Pause& a) const {
    return client(a.client) + ": pause reading";
  }
  std::string operator()(const gateway::Resume& a) const {
    return client(a.client) + ": resume reading";
  }
  std::string operator()(const gateway::Close& a) const { return client(a.client) + ": close"; }
  std::string operator()(const gateway::Open& a) const { return bus(a.bus) + ": open the line"; }
  std::string operator()(const gateway::Look& a) const { return bus(a.bus) + ": look at the line"; }
  std::string operator()(const gateway::Transmit& a) const {
    return bus(a.bus) + " > " +
           modbus::describe_rtu({a.frame.data(), a.frame.size()}, modbus::Direction::request);
  }
  std::string operator()(const gateway::Shut& a) const { return bus(a.bus) + ": close the line"; }
  std::string operator()(const gateway::Report& a) const {
    return report::to_text(a.event, settings);
  }
  std::string operator()(const gateway::Finished& /*a*/) const { return "finished"; }

 private:
  static std::string client(gateway::ClientId id) {
    return "client " + std::to_string(static_cast<std::uint32_t>(id));
  }
  [[nodiscard]] std::string bus(gateway::BusId id) const { return "bus " + settings.bus(id).name; }
};

/// One line for a trace. The names are taken from the settings.
inline std::string action_text(const gateway::Action& action, const gateway::Settings& settings) {
  return std::visit(ActionText{settings}, action);
}

}  // namespace mbgate::test
