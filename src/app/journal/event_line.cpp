// SPDX-License-Identifier: Apache-2.0
#include "app/journal/event_line.hpp"

#include <string>
#include <type_traits>
#include <variant>

#include "app/journal/event_topic.hpp"

namespace mbgate::app {
namespace {

template <typename Kind, typename... Kinds>
constexpr bool kIsOneOf = (std::is_same_v<Kind, Kinds> || ...);

Level level_of(const gateway::Event& event) {
  return std::visit(
      [](const auto& value) {
        using Kind = std::decay_t<decltype(value)>;
        constexpr bool kOrdinary = kIsOneOf<Kind, gateway::BusOpened, gateway::ClientDisplaced,
                                            gateway::ClientFrameTimedOut, gateway::WriteAccepted,
                                            gateway::CountersCleared, gateway::ClientLoggedIn>;
        return kOrdinary ? Level::notice : Level::warning;
      },
      event);
}

/// Events of one kind at one place share a rate limit: a bus that flaps must not hide another.
std::string kind_of(const gateway::Event& event) {
  return std::visit(
      [&](const auto& value) {
        std::string kind = std::to_string(event.index());
        if constexpr (requires { value.bus, value.address; }) {
          return kind + " bus " + std::to_string(static_cast<std::uint32_t>(value.bus)) +
                 " address " + std::to_string(value.address);
        } else if constexpr (requires { value.bus; }) {
          return kind + " bus " + std::to_string(static_cast<std::uint32_t>(value.bus));
        } else {
          return kind + " listener " + std::to_string(static_cast<std::uint32_t>(value.listener));
        }
      },
      event);
}

/// The machine counts these for each client: one must not use up the places of another.
bool is_limited_already(const gateway::Event& event) {
  return std::holds_alternative<gateway::StopDenied>(event) ||
         std::holds_alternative<gateway::CountersCleared>(event) ||
         std::holds_alternative<gateway::ClientLoggedIn>(event);
}

}  // namespace

void write_event(Log& log, const gateway::Event& event, const gateway::Settings& settings) {
  const std::string text = to_text(event, settings);
  const Topic topic = topic_of(event, settings);
  if (std::holds_alternative<gateway::WriteAccepted>(event)) {
    log.write_unobserved(level_of(event), text, topic);
  } else if (is_limited_already(event)) {
    log.write(level_of(event), text, topic);
  } else {
    log.write_limited(level_of(event), kind_of(event), text, topic);
  }
}

}  // namespace mbgate::app
