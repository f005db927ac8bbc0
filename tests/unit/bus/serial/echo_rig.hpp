// SPDX-License-Identifier: Apache-2.0
// A bus whose line may hear itself.
#pragma once

#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {

inline constexpr auto kWritePdu = "06 0000 0001";
inline constexpr auto kRepetition =
    "01 06 00 00 00 01 48 0A";  // the frame, its echo, and its answer
inline constexpr auto kRefusal = "01 86 02 C3 A1";

class BusEcho : public Bus {
 protected:
  void open_as(bus::LineKind kind, std::optional<bool> echo = {},
               const std::vector<drive::Device>& devices = {}) {
    auto learning = settings();
    learning.line.echo = echo;
    bus_.emplace(learning, devices);
    bus_->start();
    bus_->handle_opened(now_, kind);
    drain();
    advance(5ms);
  }
  /// The device answers, and what came before its answer may have been an echo.
  void hear_device() {
    submit(job(kRead));
    advance(10ms);
    line(std::string("00") + kAnswer);
    advance(10ms);
    ASSERT_THAT(endings_, ElementsAre(Ending::answered));
    endings_.clear();
  }
  /// A read shows that the line hears itself.
  void open_and_learn(bus::LineKind kind) {
    open_as(kind);
    submit(job(kRead));
    advance(10ms);
    line(std::string(kReadFrame) + kAnswer);
    advance(10ms);
  }
};

}  // namespace mbgate::test
