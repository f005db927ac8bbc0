// SPDX-License-Identifier: Apache-2.0
// A plant with failsafe writes, a client of which is connected.
#pragma once

#include <gmock/gmock.h>

#include "unit/gateway/writes/watched_plant.hpp"

namespace mbgate::test {

inline constexpr auto kPlc = "192.0.2.1";
inline constexpr auto kPanel = "192.0.2.2";

class FailsafeCauses : public testing::Test {
 protected:
  explicit FailsafeCauses(Settings settings = watched_plant()) : rig_(std::move(settings)) {
    rig_.connect(1, kPlc);
  }
  /// Nothing is written within this time.
  void expect_none(Duration time) {
    rig_.advance(time);
    EXPECT_THAT(take_requests(rig_), testing::IsEmpty());
  }
  void expect_writes() { EXPECT_THAT(answer_all(rig_), testing::ElementsAre(kStop1, kSecond)); }
  MachineRig rig_;
};

}  // namespace mbgate::test
