// SPDX-License-Identifier: Apache-2.0
// A drive: it carries requests out on its registers, at one instant each. When and how its answer
// goes out is the business of its line.
#pragma once

#include "world/ledger.hpp"
#include "world/plan.hpp"

namespace mbgate::world {

class Drive {
 public:
  Drive(const DrivePlan& plan, std::size_t number, std::uint64_t salt)
      : habits(plan.habits), number_(number), registers_(salt) {
    registers_.write(Table::holding_registers, kOrderRegister,
                     plan.order == drive::WordOrder::big ? kBigOrder : kLittleOrder,
                     Instant::min());
  }

  [[nodiscard]] const Registers& registers() const { return registers_; }
  [[nodiscard]] std::size_t number() const { return number_; }
  [[nodiscard]] bool has_supply(Instant now) const { return !habits.dead && now >= dark_until_; }
  void lose_supply(Instant until) { dark_until_ = std::max(dark_until_, until); }
  /// When it has done what it was asked before.
  [[nodiscard]] Instant& free() { return free_; }

  /// Carries out what was transmitted and notes it; its answer, or none if it never answers that.
  std::optional<Octets> carry_out(Ledger& ledger, Id sent, Octets pdu, Instant now);
  /// Nothing is wrong with it any more.
  void calm_down() {
    const Duration quick = habits.quick;
    habits = Habits{};
    habits.quick = quick;
    dark_until_ = free_ = Instant::min();
  }

  Habits habits;

 private:
  [[nodiscard]] Octets read(std::uint8_t function, const Range& range, Instant now) const;
  [[nodiscard]] Octets tell(Bytes pdu, Instant now) const;
  void write(std::uint8_t function, const Fields& fields, Instant now);

  std::size_t number_;
  Registers registers_;
  Instant dark_until_ = Instant::min();
  Instant free_ = Instant::min();
};

/// Is it carried out, but never answered?
bool is_silent_write(Bytes pdu);

}  // namespace mbgate::world
