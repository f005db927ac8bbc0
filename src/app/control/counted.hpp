// SPDX-License-Identifier: Apache-2.0
// One of something that is counted, as long as it is there.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>

namespace mbgate::app {

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

}  // namespace mbgate::app
