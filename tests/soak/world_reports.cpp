// SPDX-License-Identifier: Apache-2.0
// What the gateway says of lines and clients.
#include <algorithm>

#include "soak/world.hpp"

namespace mbgate::soak {
namespace {

bool is_text_of_any(const std::string& text) {
  for (unsigned host = 0; host < kMostHosts; ++host) {
    if (text == text_of(host)) {
      return true;
    }
  }
  return false;
}

}  // namespace

void World::check_report(const gateway::Event& event) {
  const auto bus_of = [](gateway::BusId bus) { return static_cast<std::size_t>(bus); };
  if (const auto* news = std::get_if<gateway::LineNews>(&event)) {
    oracle_.line_news(bus_of(news->bus), news->fault);
  } else if (std::holds_alternative<gateway::ReadDenied>(event) ||
             std::holds_alternative<gateway::WriteDenied>(event) ||
             std::holds_alternative<gateway::StopDenied>(event)) {
    report_.fault("denied");
  } else if (const auto* silent = std::get_if<gateway::AdapterSilent>(&event)) {
    object(bus_of(silent->bus), hangs_.told(bus_of(silent->bus)));
  }
  // Whoever it is about is called by an address that a host has, as RFC 5952 writes it.
  std::visit(
      [this](const auto& it) {
        if constexpr (requires { it.address.to_text(); }) {
          if (!is_text_of_any(it.address.to_text())) {
            oracle_.violation("told_wrongly", "of a client at " + it.address.to_text());
          }
        }
      },
      event);
}

}  // namespace mbgate::soak
