// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/device.hpp"

namespace mbgate::sim {
namespace {

constexpr ExceptionByte kDeviceFailure = 0x04;
constexpr ExceptionByte kDeviceBusy = 0x06;

constexpr Duration kUsualProcessing = std::chrono::milliseconds(1);

std::uint8_t next_address(std::uint8_t address) {
  return address < modbus::kMaxDeviceAddress ? static_cast<std::uint8_t>(address + 1)
                                             : std::uint8_t{1};
}

modbus::Pdu with_next_function(const modbus::Pdu& pdu) {
  std::vector<std::uint8_t> bytes(pdu.bytes().begin(), pdu.bytes().end());
  ++bytes[0];
  return *modbus::Pdu::from(bytes);
}

}  // namespace

DeviceSettings with_processing(DeviceSettings settings, bool paced) {
  if (!settings.processing) {
    settings.processing = paced ? kUsualProcessing : Duration{0};
  }
  return settings;
}

Device::Device(const DeviceSettings& settings, Framing framing)
    : settings_(settings), framing_(framing), model_(make_model(settings)) {}

Device::Model Device::make_model(const DeviceSettings& settings) {
  switch (settings.model) {
    case ModelKind::moons: return MoonsDrive(settings.series, settings.word_order);
    case ModelKind::stepper: return StepperDrive();
    case ModelKind::fda6000: return Fda6000Drive();
    case ModelKind::aic: break;
  }
  AicDrive drive;
  if (settings.response_wait) {
    using std::chrono::milliseconds;
    drive.set_response_wait(std::chrono::duration_cast<milliseconds>(*settings.response_wait));
  }
  return drive;
}

std::optional<Answer> Device::receive(modbus::Bytes frame, Instant end) {
  const auto adu = decode_frame(framing_, frame);
  const auto reply = adu ? receive(*adu, end) : std::nullopt;
  if (!reply) {
    return std::nullopt;
  }
  Answer answer{static_cast<const AnswerTime&>(*reply),
                encode_frame(framing_, reply->adu.address, reply->adu.pdu)};
  if (settings_.faults.bad_crc) {
    spoil_check(framing_, answer.frame);
  }
  return answer;
}

std::optional<Reply> Device::receive(const modbus::RtuAdu& adu, Instant end) {
  if (settings_.faults.silent || end < deaf_until_) {
    return std::nullopt;
  }
  const bool addressed = adu.address == settings_.address;
  if (!addressed && adu.address != broadcast_address()) {
    return std::nullopt;
  }
  ++heard_;
  const Reaction reaction = addressed ? react(adu, end < busy_until_) : hear_broadcast(adu.pdu);
  if (reaction.deaf_for > Duration{0}) {
    deaf_until_ = end + reaction.deaf_for;
  }
  if (reaction.busy_for > Duration{0}) {
    busy_until_ = end + reaction.busy_for;
  }
  if (!reaction.response) {
    return std::nullopt;
  }
  return spoil(*reaction.response, reaction.delay);
}

std::uint8_t Device::broadcast_address() const {
  return std::visit([](const auto& drive) { return drive.kBroadcastAddress; }, model_);
}

Reaction Device::hear_broadcast(const modbus::Pdu& pdu) {
  return std::visit([&pdu](auto& drive) { return drive.hear_broadcast(pdu); }, model_);
}

Reaction Device::react(const modbus::RtuAdu& adu, bool busy) {
  ++addressed_;
  const unsigned every = settings_.faults.exception_every;
  if (every != 0 && addressed_ % every == 0) {
    return {exception(adu.pdu.function(), kDeviceFailure)};
  }
  if (busy) {
    return {exception(adu.pdu.function(), kDeviceBusy)};
  }
  return std::visit([&](auto& drive) { return drive.answer(adu.pdu); }, model_);
}

Reply Device::spoil(const modbus::Pdu& response, Duration delay) const {
  const Faults& faults = settings_.faults;
  const std::uint8_t address =
      faults.wrong_unit ? next_address(settings_.address) : settings_.address;
  Reply reply{{delay + settings_.processing.value_or(Duration{0}), false},
              {address, faults.wrong_function ? with_next_function(response) : response}};
  if (settings_.model != ModelKind::aic) {
    reply.after += settings_.response_wait.value_or(Duration{0});
  }
  if (faults.answer_after) {
    reply.after = *faults.answer_after;
    reply.counts_from_end = true;
  }
  return reply;
}

}  // namespace mbgate::sim
