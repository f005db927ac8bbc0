// SPDX-License-Identifier: Apache-2.0
// The text forms of actions.
#include <fmt/format.h>

#include "gateway/action.hpp"
#include "modbus/describe.hpp"

namespace mbgate::gateway {
namespace {

template <typename... Handlers>
struct ActionTexts : Handlers... {
  using Handlers::operator()...;
};

std::string client_number(ClientId client) {
  return fmt::format("client {}", fmt::underlying(client));
}

std::string named_bus(const Settings& settings, BusId bus) {
  return "bus " + settings.bus(bus).name;
}

}  // namespace

std::string to_text(const Action& action, const Settings& settings) {
  return std::visit(
      ActionTexts{[&](const Send& a) {
                    return fmt::format("{} < {}", client_number(a.client),
                                       modbus::describe_mbap({a.adu.data(), a.adu.size()},
                                                             modbus::Direction::response));
                  },
                  [&](const Pause& a) { return client_number(a.client) + ": pause reading"; },
                  [&](const Resume& a) { return client_number(a.client) + ": resume reading"; },
                  [&](const Close& a) { return client_number(a.client) + ": close"; },
                  [&](const Open& a) { return named_bus(settings, a.bus) + ": open the line"; },
                  [&](const Look& a) { return named_bus(settings, a.bus) + ": look at the line"; },
                  [&](const Transmit& a) {
                    return fmt::format("{} > {}", named_bus(settings, a.bus),
                                       modbus::describe_rtu({a.frame.data(), a.frame.size()},
                                                            modbus::Direction::request));
                  },
                  [&](const Shut& a) { return named_bus(settings, a.bus) + ": close the line"; },
                  [&](const Report& a) { return to_text(a.event, settings); },
                  [&](const Finished&) { return std::string("finished"); }},
      action);
}

}  // namespace mbgate::gateway
