// SPDX-License-Identifier: Apache-2.0
// Limits the clients that follow a stream, events or the trace: each holds a descriptor as long as
// it reads. A quarter of the places, and at least one, is reserved for the Unix socket, so that
// readers over a network keep no operator out.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace mbgate::app {

/// One of something that is counted, as long as it is there.
class Counted {
 public:
  /// It may be there for longer than whoever looks at the count.
  explicit Counted(std::shared_ptr<std::size_t> count) : count_(std::move(count)) { ++*count_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  ~Counted() { --*count_; }

 private:
  std::shared_ptr<std::size_t> count_;
};

class StreamPlaces {
 public:
  explicit StreamPlaces(std::size_t most) : most_(most) {}

  /// Whoever has a place keeps it.
  void set_most(std::size_t most) { most_ = most; }
  /// What is said to whoever gets no place; nothing if there is one.
  [[nodiscard]] std::optional<std::string> refusal(bool over_tcp) const {
    const std::size_t taken = *of_socket_ + *of_tcp_;
    if (taken >= most_) {
      return std::to_string(taken) +
             " clients follow events or the trace already, [http] max_streams allows " +
             std::to_string(most_);
    }
    if (over_tcp && *of_tcp_ >= most_over_tcp()) {
      return std::to_string(*of_tcp_) +
             " clients follow events or the trace over TCP already, [http] max_streams = " +
             std::to_string(most_) + " allows " + std::to_string(most_over_tcp()) + " there";
    }
    return std::nullopt;
  }
  /// A place, until it is destroyed. To be taken only while there is one.
  [[nodiscard]] Counted take(bool over_tcp) const {
    return Counted(over_tcp ? of_tcp_ : of_socket_);
  }

 private:
  [[nodiscard]] std::size_t most_over_tcp() const {
    constexpr std::size_t kShare = 4;
    return most_ - std::max<std::size_t>(most_ / kShare, 1);
  }

  std::size_t most_;  ///< one at least
  std::shared_ptr<std::size_t> of_socket_ = std::make_shared<std::size_t>(0);
  std::shared_ptr<std::size_t> of_tcp_ = std::make_shared<std::size_t>(0);
};

}  // namespace mbgate::app
