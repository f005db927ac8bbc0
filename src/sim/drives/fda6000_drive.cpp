// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/fda6000_drive.hpp"

#include <array>

namespace mbgate::sim {
namespace {

// The manual states no limit of its own, so the protocol's hold.
constexpr RegisterRules kFdaRules{.most_read = 125, .most_written = 123};

constexpr ExceptionByte kIllegalFunction = 0x01;
constexpr ExceptionByte kIllegalAddress = 0x02;
constexpr ExceptionByte kAcknowledge = 0x05;
constexpr ExceptionByte kNegativeAcknowledge = 0x07;

// 3.4: JOG, auto-JOG, simulation and two more. The last one, 74, is printed as h50, which is 80.
bool is_own_function(std::uint8_t function) {
  return (function >= 0x46 && function <= 0x4A) || function == 0x50;
}

ExceptionByte refusal_of(std::uint8_t function) {
  switch (function) {
    case 0x01: return kIllegalAddress;  // 7.3: of coils there is none
    case 0x0D:
    case 0x0E: return kNegativeAcknowledge;  // 7.4
    default: return kIllegalFunction;
  }
}

bool is_masked(std::uint16_t address, std::uint16_t word) {
  return word == kFdaMask && address >= kFdaFirstMasked && address <= kFdaLastMasked;
}

}  // namespace

Fda6000Drive::Fda6000Drive() : registers_(fda6000_registers(), drive::WordOrder::big) {}

Reaction Fda6000Drive::answer(const modbus::Pdu& pdu) {
  const std::uint8_t function = pdu.function();
  if (is_own_function(function)) {
    return {pdu};
  }
  const auto request = request_of(pdu, {0x03, 0x06, 0x10}, refusal_of(function));
  if (!request) {
    return request.error();
  }
  return request->reads() ? Reaction{serve_read(*request, registers_, kFdaRules)} : write(*request);
}

Reaction Fda6000Drive::hear_broadcast(const modbus::Pdu& /*pdu*/) { return {}; }

Reaction Fda6000Drive::write(const modbus::Request& request) {
  const modbus::TableRange& range = request.writes()->range;
  if (const auto refusal = store(range.first, written_words(request))) {
    return {exception(request.function(), code_of(*refusal, kFdaRules))};
  }
  if (touches(range, kFdaParameterInit) && registers_.get(kFdaParameterInit) == 1) {
    registers_.restore_initial();
    Reaction reaction{exception(request.function(), kAcknowledge)};
    reaction.busy_for = kParameterInitTime;
    return reaction;
  }
  return {modbus::echo_response(request)};
}

// 6.4: what is masked stays as it is, whoever may write it. All or nothing, so a copy is tried.
std::optional<Refusal> Fda6000Drive::store(std::uint16_t first, const Registers& words) {
  const auto present = registers_.read(first, static_cast<std::uint16_t>(words.size()));
  if (!present) {
    return present.error();
  }
  RegisterBank trial = registers_;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto address = static_cast<std::uint16_t>(first + i);
    if (is_masked(address, words[i])) {
      continue;
    }
    if (const auto refusal = trial.write(address, std::array{words[i]})) {
      return refusal;
    }
  }
  registers_ = trial;
  return std::nullopt;
}

}  // namespace mbgate::sim
