// SPDX-License-Identifier: Apache-2.0
// A busy line on which reads wait, and are answered together.
#pragma once

#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {

inline constexpr auto kStranger = "02 03 02 12 34 F1 33";

class BusSharing : public Bus {
 protected:
  static bus::BusSettings sharing() {
    auto sharing = settings();
    sharing.coalesce = true;
    return sharing;
  }
  /// The line is busy until free_line().
  void occupy() {
    submit(job_of(99, kRead, 2));
    advance(10ms);
  }
  void free_line() {
    line(kStranger);
    advance(5ms);
    frames_.erase(frames_.begin());
    endings_.erase(endings_.begin());
  }
  /// Two identical reads waited, and the line has become free.
  void let_two_wait(const bus::BusSettings& settings) {
    open(settings);
    occupy();
    submit(job_of(0, kRead));
    submit(job_of(1, kRead));
    free_line();
  }
  /// Two identical reads have waited with a write between them, and now a read has its turn.
  void let_two_wait_around(std::uint8_t written) {
    auto reads_first = sharing();
    reads_first.burst = 1;
    open(reads_first);
    submit(job_of(98, "06 0000 0001", 3));
    advance(10ms);
    submit(job_of(0, kRead));
    submit(job_of(1, "06 0000 0001", written));
    submit(job_of(2, kRead));
    line("03 06 00 00 00 01 49 E8");
    advance(10ms);
  }
  void answer() {
    advance(10ms);
    line(kAnswer);
  }
  static std::string response_of(const bus::Job& job) {
    const auto& response = job.transactions[0].response;
    return response ? hex(response->bytes()) : "none";
  }
};

}  // namespace mbgate::test
