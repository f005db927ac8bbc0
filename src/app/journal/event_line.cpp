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

/// A device, a line or an adapter that is well again, or an echo that was found or has gone.
bool is_recovery(const gateway::Event& event) {
  if (const auto* const device = std::get_if<gateway::DeviceNews>(&event)) {
    return device->notice.kind == bus::DeviceNotice::Kind::back;
  }
  if (const auto* const line = std::get_if<gateway::LineNews>(&event)) {
    return line->fault == bus::LineFault::echo_found || line->fault == bus::LineFault::echo_gone;
  }
  const auto* const quality = std::get_if<gateway::QualityNews>(&event);
  return quality != nullptr && (quality->notice.verdict.quality == bus::Quality::good ||
                                quality->notice.verdict.quality == bus::Quality::unknown);
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

Level level_of(const gateway::Event& event) {
  const bool is_ordinary = std::visit(
      [](const auto& value) {
        return kIsOneOf<std::decay_t<decltype(value)>, gateway::BusOpened, gateway::ClientDisplaced,
                        gateway::ClientFrameTimedOut, gateway::WriteAccepted,
                        gateway::CountersCleared, gateway::ClientLoggedIn>;
      },
      event);
  return is_ordinary || is_recovery(event) ? Level::notice : Level::warning;
}

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
