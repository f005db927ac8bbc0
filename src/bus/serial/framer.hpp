// SPDX-License-Identifier: Apache-2.0
// The framing of a serial line, RTU or ASCII: makes frames of requests and finds their responses in
// what comes back. RtuFramer and AsciiFramer say what each function promises.
#pragma once

#include <variant>

#include "bus/serial/ascii_framer.hpp"
#include "bus/serial/rtu_framer.hpp"
#include "bus/settings.hpp"

namespace mbgate::bus {

class Framer {
 public:
  Framer(const BusSettings& settings, const modbus::RtuTiming& timing, BusCounters& counters)
      : framer_(settings.line.framing == Framing::ascii
                    ? Variant(std::in_place_type<AsciiFramer>, timing,
                              settings.frame_slack_or_default(), counters)
                    : Variant(std::in_place_type<RtuFramer>, timing,
                              settings.frame_slack_or_default(), counters)) {}
  /// Other times on the same line.
  void update(const BusSettings& settings) {
    std::visit([&](auto& framer) { framer.set_slack(settings.frame_slack_or_default()); }, framer_);
  }

  [[nodiscard]] FrameBytes encode(std::uint8_t address, const modbus::Pdu& pdu) const {
    const auto copied = [](const auto& frame) { return FrameBytes(frame.begin(), frame.end()); };
    return std::holds_alternative<AsciiFramer>(framer_) ? copied(modbus::encode_ascii(address, pdu))
                                                        : copied(modbus::encode_rtu(address, pdu));
  }
  void expect(const Transaction& transaction, Instant sent) {
    std::visit([&](auto& framer) { framer.expect(transaction, sent); }, framer_);
  }
  void hurry(Instant due) {
    std::visit([&](auto& framer) { framer.hurry(due); }, framer_);
  }
  Verdict add(modbus::Bytes bytes, Instant now) {
    return std::visit([&](auto& framer) { return framer.add(bytes, now); }, framer_);
  }
  Verdict handle_deadline(Instant now) {
    return std::visit([&](auto& framer) { return framer.handle_deadline(now); }, framer_);
  }
  [[nodiscard]] std::optional<Instant> next_deadline() const {
    return std::visit([](const auto& framer) { return framer.next_deadline(); }, framer_);
  }
  [[nodiscard]] bool in_progress() const {
    return std::visit([](const auto& framer) { return framer.in_progress(); }, framer_);
  }
  [[nodiscard]] bool is_amid_frame() const {
    return std::visit([](const auto& framer) { return framer.is_amid_frame(); }, framer_);
  }
  [[nodiscard]] bool awaits_silence() const {
    return std::visit([](const auto& framer) { return framer.awaits_silence(); }, framer_);
  }
  void listen() {
    std::visit([](auto& framer) { framer.listen(); }, framer_);
  }
  /// Another connection: nothing of before goes on.
  void forget() {
    std::visit([](auto& framer) { framer.forget(); }, framer_);
  }
  Verdict again(Instant now) {
    return std::visit([&](auto& framer) { return framer.again(now); }, framer_);
  }
  [[nodiscard]] const FoundResponse& found() const {
    return std::visit(
        [](const auto& framer) -> const auto& { return framer.found(); }, framer_);
  }
  [[nodiscard]] const modbus::Pdu& response() const { return *found().pdu; }
  std::optional<UnsolicitedFrame> take_unsolicited() {
    return std::visit([](auto& framer) { return framer.take_unsolicited(); }, framer_);
  }

 private:
  using Variant = std::variant<RtuFramer, AsciiFramer>;
  Variant framer_;
};

}  // namespace mbgate::bus
