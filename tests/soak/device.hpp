// SPDX-License-Identifier: Apache-2.0
// A device of the soak: carries requests out on its registers at one instant. How and when its
// answer goes out is the line's business.
#pragma once

#include <optional>

#include "drive/device.hpp"
#include "modbus/pdu.hpp"
#include "soak/registers.hpp"
#include "soak/specification.hpp"

namespace mbgate::soak {

/// Does 06 or 16 write 7xxx, perhaps among others? It is never answered because the device boots.
bool is_silent(const spec::Fields& fields);
/// 08/01 or 08/04. What is never answered, but the device listens.
bool is_listen_only(spec::Bytes request);

class SoakDevice {
 public:
  SoakDevice(const drive::Device& settings, drive::WordOrder own_order, std::uint64_t salt)
      : settings_(settings), registers_(salt) {
    registers_.write(kOrderRegister, own_order == drive::WordOrder::big ? kBigOrder : kLittleOrder,
                     Instant::min());
  }

  [[nodiscard]] const drive::Device& settings() const { return settings_; }
  /// The drive is the same; what is said of it, and its address, are others.
  void adopt(const drive::Device& settings) { settings_ = settings; }
  [[nodiscard]] const Registers& registers() const { return registers_; }
  [[nodiscard]] bool is_dead(Instant now) const { return now < dead_until_; }
  void die_until(Instant until) { dead_until_ = std::max(dead_until_, until); }
  void revive() { dead_until_ = Instant::min(); }

  /// What became of a request.
  struct Outcome {
    std::optional<modbus::Pdu> answer;  ///< none: it is never answered
    bool slow = false;
    std::optional<modbus::Pdu> parting{};  ///< what some say before they boot
  };
  Outcome carry_out(const modbus::Pdu& request, Instant now);

 private:
  [[nodiscard]] modbus::Pdu answer_to(spec::Bytes request, const spec::Fields& fields,
                                      Instant now) const;
  [[nodiscard]] modbus::Pdu read(spec::Bytes request, const spec::Range& asked, Instant now) const;
  [[nodiscard]] modbus::Pdu identify(spec::Bytes request, Instant now) const;
  void write(spec::Bytes request, const spec::Fields& fields, Instant now);
  void write_registers(const spec::Fields& fields, Instant now);
  void mask(const spec::Fields& fields, Instant now);

  drive::Device settings_;
  Registers registers_;
  Instant dead_until_ = Instant::min();
};

}  // namespace mbgate::soak
