// SPDX-License-Identifier: Apache-2.0
// Which of the answers that a serial line has brought the gateway must take.
#pragma once

#include <string_view>

#include "soak/flight.hpp"

namespace mbgate::soak {

struct Book;
class Oracle;
struct SoakPlan;

/// Why a fitting answer may not have been taken: a stop may have ended the wait for it.
constexpr std::string_view kBesideStop = "beside_stop";

/// The gateway may take what it hears for the echo of its own request.
bool may_echo(const SoakPlan& plan, const Book& book, std::size_t bus);
/// All that was heard of what was transmitted last is an answer with a bad CRC: the silence behind
/// it ends the wait.
bool is_damaged_answer(const SoakPlan& plan, const Book& book, const Flight& asked);

class HeardAnswers {
 public:
  explicit HeardAnswers(Oracle& oracle) : oracle_(oracle) {}

  /// If the answer to what was transmitted last came in time, and nothing with it that may have
  /// hidden it, it must be taken; nullptr then.
  [[nodiscard]] const char* why_unsure(const Flight& flight, const HeardFrame& frame) const;

 private:
  [[nodiscard]] bool is_behind_echo(const Flight& flight) const;
  [[nodiscard]] bool is_apart_from_noise(const Flight& flight, const HeardFrame& frame,
                                         std::size_t echo) const;
  [[nodiscard]] bool may_be_for_earlier(const Flight& stop) const;

  Oracle& oracle_;
};

}  // namespace mbgate::soak
