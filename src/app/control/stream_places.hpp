// SPDX-License-Identifier: Apache-2.0
// Places for clients that follow something without an end, whatever it is: each costs a descriptor
// as long as it reads.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "app/control/counted.hpp"

namespace mbgate::app {

class StreamPlaces {
 public:
  explicit StreamPlaces(std::size_t most) : most_(most) {}

  /// Whoever has a place keeps it.
  void set_most(std::size_t most) { most_ = most; }
  [[nodiscard]] bool are_taken() const { return *taken_ >= most_; }
  /// What is said to whoever gets none.
  [[nodiscard]] std::string refusal() const {
    return std::to_string(*taken_) + " clients follow events already, [http] max_streams allows " +
           std::to_string(most_);
  }
  /// A place, until it is destroyed. To be taken only while there are some.
  [[nodiscard]] Counted take() const { return Counted(taken_); }

 private:
  std::size_t most_;
  std::shared_ptr<std::size_t> taken_ = std::make_shared<std::size_t>(0);
};

}  // namespace mbgate::app
