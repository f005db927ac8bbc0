// SPDX-License-Identifier: Apache-2.0
// A bus whose devices go offline.
#pragma once

#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {

class BusOffline : public Bus {
 protected:
  static bus::BusSettings breaking() {
    auto breaking = settings();
    breaking.timing.offline_after = 3;
    breaking.timing.probe_timeout = 50ms;
    return breaking;
  }
  /// Probes get 2 percent of the time.
  static bus::BusSettings scarce() {
    auto scarce = breaking();
    scarce.probe_share = 2;
    return scarce;
  }
  /// Device 1 goes offline.
  void lose_device() {
    for (int times = 0; times < 3; ++times) {
      submit(job(kRead));
      advance(300ms);
    }
    EXPECT_TRUE(bus_->devices()[1].health.is_offline());
    frames_.clear();
    frame_times_.clear();
    endings_.clear();
    ended_at_.clear();
  }
  /// It is offline, and what comes while it is probed may answer one of four reads. 35 ms later
  /// other registers are asked for.
  void ask_beside_a_probe_with_a_late_answer() {
    open(breaking());
    lose_device();
    advance(2s);
    submit(job("03 0000 0001"));
    advance(20ms);
    line(kAnswer);
    advance(35ms);
    submit(job("03 0010 0001"));
  }
};

}  // namespace mbgate::test
