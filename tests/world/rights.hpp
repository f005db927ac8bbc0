// SPDX-License-Identifier: Apache-2.0
// Who may do what, in the words of docs/access-rules.md: the first rule that fits decides, what
// none fits is denied, and a request that reads and writes asks twice.
#pragma once

#include "world/ledger.hpp"
#include "world/plan.hpp"

namespace mbgate::world {

struct Verdict {
  bool permitted = true;
  bool sure = true;                  ///< else the rules may say either
  std::vector<std::size_t> rated{};  ///< rules with a rate that permit it
};

/// What the rules of the plan say of a request that can be carried out.
[[nodiscard]] Verdict verdict_of(const Plan& plan, const Intent& intent, std::size_t listener,
                                 unsigned host);
/// Rules, functions of routes, lists of writers, and how often a reload takes rights away; with a
/// chance of its own.
void draw_rights(Plan& plan);
/// A right that somebody had is gone; what kind of right.
const char* take_right(Plan& plan, Random& random);

}  // namespace mbgate::world
