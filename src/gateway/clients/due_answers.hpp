// SPDX-License-Identifier: Apache-2.0
// The answers that a client is still to get: their number, and the ones that wait for earlier
// answers (`ordered`).
#pragma once

#include <boost/container/small_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "gateway/client.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::gateway {

class DueAnswers {
 public:
  using Ready = boost::container::small_vector<modbus::MbapBytes, 1>;

  explicit DueAnswers(bool ordered) : ordered_(ordered) {}

  /// Requests whose answer is due.
  [[nodiscard]] std::size_t unanswered() const { return open_ + held_.size(); }
  /// And those whose answer has not been completely written.
  [[nodiscard]] std::size_t outstanding() const { return unanswered() + unsent_; }

  /// A request was taken: its answer is due.
  AnswerId open();
  /// `adu`: the answer; nothing: there will be none. Returns the ADUs that are to be sent now: with
  /// `ordered = true` an answer waits for those before it.
  Ready close(AnswerId id, const std::optional<modbus::MbapBytes>& adu);
  /// An answer has been completely written.
  void confirm_sent();

 private:
  struct Held {
    bool done = false;
    std::optional<modbus::MbapBytes> adu;
  };

  bool ordered_;
  std::size_t open_ = 0;    // unordered: answers that are due
  std::size_t unsent_ = 0;  // answers on their way to the socket
  std::deque<Held> held_;   // ordered: answers due or waiting, oldest first
  std::uint64_t first_held_ = 0;
};

}  // namespace mbgate::gateway
