// SPDX-License-Identifier: Apache-2.0
#include "app/journal/event_topic.hpp"

#include <fmt/format.h>
#include <string>
#include <type_traits>
#include <variant>

#include "report/text.hpp"

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
    case bus::LineFault::unanswered: return message_id::kConnectionReplaced;
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

using namespace gateway;
using namespace message_id;

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

  Topic operator()(const BusOpened& e) const { return on_bus(kBusOpened, e); }
  Topic operator()(const BusLost& e) const { return on_bus(kBusLost, e); }
  Topic operator()(const AdapterSilent& e) const { return on_bus(kAdapterSilent, e); }
  Topic operator()(const ClientRefused& e) const { return of_client(id_of_refusal(e.reason), e); }
  Topic operator()(const ClientDisplaced& e) const { return of_client(kClientDisplaced, e); }
  Topic operator()(const ClientOverRate& e) const { return of_client(kClientOverRate, e); }
  Topic operator()(const ClientFramingLost& e) const { return of_client(kClientFramingLost, e); }
  Topic operator()(const ClientSpeaksRtu& e) const { return of_client(kClientSpeaksRtu, e); }
  Topic operator()(const ClientFrameTimedOut& e) const {
    return of_client(kClientFrameTimedOut, e);
  }
  Topic operator()(const LineNews& e) const { return on_bus(id_of_fault(e.fault), e); }
  Topic operator()(const LineNeverSilent& e) const { return on_bus(kLineNeverSilent, e); }
  Topic operator()(const Reconfigured& e) const {
    Topic topic = of_device(kReconfigured, e.bus, e.address);
    topic.client = e.client.to_text();
    return topic;
  }
  Topic operator()(const WriteEndedEarly& e) const {
    return of_device(kWriteEndedEarly, e.bus, e.address);
  }
  Topic operator()(const WordOrderDiffers& e) const {
    return of_device(kWordOrderDiffers, e.bus, e.address);
  }
  Topic operator()(const DeviceNews& e) const {
    return of_device(id_of_notice(e.notice), e.bus, e.notice.address);
  }
  Topic operator()(const QualityNews& e) const {
    const MessageId id = id_of_quality(e.notice);
    return e.notice.address ? of_device(id, e.bus, *e.notice.address) : on_bus(id, e);
  }
  Topic operator()(const FailsafeNews& e) const {
    return of_device(id_of_outcome(e.outcome), e.bus, e.address);
  }
  Topic operator()(const UnitNotRouted& e) const { return of_client(kUnitNotRouted, e); }
  Topic operator()(const ReadDenied& e) const { return of_request(kRequestDenied, e); }
  Topic operator()(const WriteDenied& e) const { return of_request(kRequestDenied, e); }
  Topic operator()(const StopDenied& e) const { return of_request(kStopDenied, e); }
  Topic operator()(const WriteAccepted& e) const { return of_write(e); }
  Topic operator()(const BroadcastLeavesOut& e) const { return of_request(kBroadcastLeavesOut, e); }
  Topic operator()(const CountersCleared& e) const { return of_request(kCountersCleared, e); }
  Topic operator()(const ClientLoggedIn& e) const { return of_asker(kClientLoggedIn, e); }
};

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

/// Events of one kind at one place share a rate limit: what happens again and again must not hide
/// what happens elsewhere, nor news of the same device, nor what concerns a stop.
std::string kind_of(const gateway::Event& event, const Topic& topic) {
  const auto* const broadcast = std::get_if<gateway::BroadcastLeavesOut>(&event);
  return fmt::format("{} {} bus {} address {} listener {} stop {}", event.index(), topic.id.hex,
                     topic.bus, topic.address, topic.listener,
                     broadcast != nullptr && broadcast->is_stop);
}

/// The machine counts these for each client: one must not use up the places of another.
bool is_limited_already(const gateway::Event& event) {
  return std::holds_alternative<gateway::StopDenied>(event) ||
         std::holds_alternative<gateway::CountersCleared>(event) ||
         std::holds_alternative<gateway::ClientLoggedIn>(event);
}

}  // namespace

Topic topic_of(const gateway::Event& event, const gateway::Settings& settings) {
  return std::visit(Topics{settings}, event);
}

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
  const std::string text = report::to_text(event, settings);
  const Topic topic = topic_of(event, settings);
  if (std::holds_alternative<gateway::WriteAccepted>(event)) {
    log.write_unobserved(level_of(event), text, topic);
  } else if (is_limited_already(event)) {
    log.write(level_of(event), text, topic);
  } else {
    log.write_limited(level_of(event), kind_of(event, topic), text, topic);
  }
}

}  // namespace mbgate::app
