// SPDX-License-Identifier: Apache-2.0
#include "app/journal/event_topic.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <type_traits>
#include <variant>

namespace mbgate::app {
namespace {

MessageId id_of_fault(bus::LineFault fault) {
  switch (fault) {
    case bus::LineFault::echo_differed: return message_id::kEchoDiffered;
    case bus::LineFault::framing_lost:
    case bus::LineFault::answer_cut_off: return message_id::kFramingLost;
    case bus::LineFault::driver_stalled: return message_id::kDriverStalled;
    case bus::LineFault::echo_found: return message_id::kEchoFound;
    case bus::LineFault::echo_gone: return message_id::kEchoGone;
    case bus::LineFault::echo_denied: return message_id::kEchoDenied;
    case bus::LineFault::echo_unproven: return message_id::kEchoUnproven;
    case bus::LineFault::answered_while_sending: return message_id::kAnsweredWhileSending;
    case bus::LineFault::unanswered: return message_id::kLineUnanswered;
  }
  return {};
}

MessageId id_of_notice(const bus::DeviceNotice& notice) {
  using Kind = bus::DeviceNotice::Kind;
  switch (notice.kind) {
    case Kind::lost:
      return notice.answered_before ? message_id::kDeviceLost : message_id::kDeviceNeverAnswered;
    case Kind::back: return message_id::kDeviceBack;
    case Kind::late: return message_id::kDeviceLate;
    case Kind::early: return message_id::kDeviceEarly;
    case Kind::foreign:
      return notice.is_request ? message_id::kForeignRequest : message_id::kForeignFrame;
    case Kind::misfit: return message_id::kMisfit;
    case Kind::pauses: return message_id::kAnswerPauses;
    case Kind::second_answer: return message_id::kSecondAnswer;
    case Kind::stop_unanswered: return message_id::kStopUnanswered;
    case Kind::stop_refused: return message_id::kStopRefused;
    case Kind::stop_forced: return message_id::kStopForced;
  }
  return {};
}

MessageId id_of_quality(const bus::QualityNotice& notice) {
  switch (notice.verdict.quality) {
    case bus::Quality::unknown:
    case bus::Quality::good: return message_id::kQualityGood;
    case bus::Quality::bad_crc:
      return notice.address ? message_id::kDeviceBadCrc : message_id::kLineBadCrc;
    case bus::Quality::no_frame: return message_id::kNoFrame;
    case bus::Quality::late: return message_id::kLateAnswers;
  }
  return {};
}

MessageId id_of_outcome(gateway::FailsafeOutcome outcome) {
  switch (outcome) {
    case gateway::FailsafeOutcome::acknowledged: return message_id::kFailsafeAcknowledged;
    case gateway::FailsafeOutcome::waits: return message_id::kFailsafeWaits;
    case gateway::FailsafeOutcome::client_back: return message_id::kFailsafeClientBack;
    case gateway::FailsafeOutcome::given_up: return message_id::kFailsafeGivenUp;
    case gateway::FailsafeOutcome::device_gone: return message_id::kFailsafeDeviceGone;
  }
  return {};
}

MessageId id_of_refusal(gateway::RefusalReason reason) {
  switch (reason) {
    case gateway::RefusalReason::not_allowed: return message_id::kClientNotAllowed;
    case gateway::RefusalReason::full: return message_id::kClientNoRoom;
    case gateway::RefusalReason::stopping: return message_id::kClientWhileStopping;
    case gateway::RefusalReason::no_rule: return message_id::kClientNotRuled;
    case gateway::RefusalReason::address_full: return message_id::kClientAddressFull;
    case gateway::RefusalReason::too_often: return message_id::kClientTooOften;
  }
  return {};
}

struct Topics {
  const gateway::Settings& settings;

  [[nodiscard]] Topic on_bus(MessageId id, const auto& event) const {
    return {.id = id, .bus = settings.bus(event.bus).name};
  }
  [[nodiscard]] Topic of_client(MessageId id, const auto& event) const {
    return {.id = id,
            .client = event.address.to_text(),
            .listener = settings.listener(event.listener).name};
  }
  [[nodiscard]] Topic of_asker(MessageId id, const gateway::Asker& asker) const {
    Topic topic = of_client(id, asker);
    topic.role = asker.role.name;
    topic.certificate = asker.role.certificate;
    return topic;
  }
  [[nodiscard]] Topic of_request(MessageId id, const gateway::Asked& asked) const {
    Topic topic = of_asker(id, asked);
    topic.unit = std::to_string(asked.unit);
    topic.function = std::to_string(asked.pdu.front());
    return topic;
  }
  [[nodiscard]] Topic of_device(MessageId id, gateway::BusId bus, std::uint8_t address) const {
    return {.id = id,
            .bus = settings.bus(bus).name,
            .device = settings.device_name(bus, address),
            .address = std::to_string(address)};
  }
  [[nodiscard]] Topic of_write(const gateway::WriteAccepted& write) const {
    Topic topic = of_request(message_id::kWriteAccepted, write);
    if (write.target) {
      const Topic target = of_device({}, write.target->bus, write.target->address);
      topic.bus = target.bus;
      topic.device = target.device;
      topic.address = target.address;
    }
    return topic;
  }
};

template <typename... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};

}  // namespace

Topic topic_of(const gateway::Event& event, const gateway::Settings& settings) {
  using namespace gateway;
  using namespace message_id;
  const Topics topics{settings};
  return std::visit(
      Overloaded{
          [&](const BusOpened& e) { return topics.on_bus(kBusOpened, e); },
          [&](const BusLost& e) { return topics.on_bus(kBusLost, e); },
          [&](const AdapterSilent& e) { return topics.on_bus(kAdapterSilent, e); },
          [&](const ConnectionReplaced& e) { return topics.on_bus(kConnectionReplaced, e); },
          [&](const ClientRefused& e) { return topics.of_client(id_of_refusal(e.reason), e); },
          [&](const ClientDisplaced& e) { return topics.of_client(kClientDisplaced, e); },
          [&](const ClientOverRate& e) { return topics.of_client(kClientOverRate, e); },
          [&](const ClientFramingLost& e) { return topics.of_client(kClientFramingLost, e); },
          [&](const ClientSpeaksRtu& e) { return topics.of_client(kClientSpeaksRtu, e); },
          [&](const ClientFrameTimedOut& e) { return topics.of_client(kClientFrameTimedOut, e); },
          [&](const LineNews& e) { return topics.on_bus(id_of_fault(e.fault), e); },
          [&](const LineNeverSilent& e) { return topics.on_bus(kLineNeverSilent, e); },
          [&](const Reconfigured& e) {
            Topic topic = topics.of_device(kReconfigured, e.bus, e.address);
            topic.client = e.client.to_text();
            return topic;
          },
          [&](const WriteEndedEarly& e) {
            return topics.of_device(kWriteEndedEarly, e.bus, e.address);
          },
          [&](const WordOrderDiffers& e) {
            return topics.of_device(kWordOrderDiffers, e.bus, e.address);
          },
          [&](const DeviceNews& e) {
            return topics.of_device(id_of_notice(e.notice), e.bus, e.notice.address);
          },
          [&](const QualityNews& e) {
            const MessageId id = id_of_quality(e.notice);
            return e.notice.address ? topics.of_device(id, e.bus, *e.notice.address)
                                    : topics.on_bus(id, e);
          },
          [&](const FailsafeNews& e) {
            return topics.of_device(id_of_outcome(e.outcome), e.bus, e.address);
          },
          [&](const UnitNotRouted& e) { return topics.of_client(kUnitNotRouted, e); },
          [&](const ReadDenied& e) { return topics.of_request(kRequestDenied, e); },
          [&](const WriteDenied& e) { return topics.of_request(kRequestDenied, e); },
          [&](const StopDenied& e) { return topics.of_request(kStopDenied, e); },
          [&](const WriteAccepted& e) { return topics.of_write(e); },
          [&](const BroadcastLeavesOut& e) { return topics.of_request(kBroadcastLeavesOut, e); },
          [&](const CountersCleared& e) { return topics.of_request(kCountersCleared, e); },
          [&](const ClientLoggedIn& e) { return topics.of_asker(kClientLoggedIn, e); }},
      event);
}

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
          return fmt::format("{} bus {} address {}", kind, fmt::underlying(value.bus),
                             value.address);
        } else if constexpr (requires { value.bus; }) {
          return fmt::format("{} bus {}", kind, fmt::underlying(value.bus));
        } else {
          return fmt::format("{} listener {}", kind, fmt::underlying(value.listener));
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
