// SPDX-License-Identifier: Apache-2.0
// A framer alone, RTU or ASCII, and a clock that stands still unless a test moves it.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "bus/counters.hpp"
#include "bus/job.hpp"
#include "bus/line_end.hpp"
#include "support/hex.hpp"

namespace mbgate::test {

using namespace std::chrono_literals;
using bus::Duration;
using bus::Instant;
using bus::Verdict;

template <class Framer>
class FramerRig : public testing::Test {
 protected:
  /// The framer is made of `arguments` and the counters.
  template <class... Arguments>
  explicit FramerRig(Arguments... arguments) : framer_(arguments..., counters_) {}

  void expect(std::string_view request, std::uint8_t address = 1) {
    const auto pdu = modbus::Pdu::from(unhex(request));
    transaction_.emplace(bus::Transaction{address, *modbus::Request::parse(*pdu)});
    framer_.expect(*transaction_);
  }
  Verdict add(modbus::Bytes bytes) { return framer_.add(bytes, now_); }
  Verdict after(Duration duration) {
    now_ += duration;
    return framer_.handle_deadline(now_);
  }
  std::string response() { return hex(framer_.found().pdu->bytes()); }

  Instant now_{10s};
  bus::BusCounters counters_;
  std::optional<bus::Transaction> transaction_;
  Framer framer_;
};

}  // namespace mbgate::test
