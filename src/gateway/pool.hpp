// SPDX-License-Identifier: Apache-2.0
// Reusable objects. An object has a stable address while it is in use. The pool grows to the
// largest number ever in use. Each member of an object has an initialiser or a constructor: nothing
// is filled with zeros before, which takes long where there is room for several PDUs.
#pragma once

#include <cstdint>
#include <memory>
#include <new>
#include <vector>

namespace mbgate::gateway {

template <typename Object>
class Pool {
 public:
  std::uint32_t take() {
    if (free_.empty()) {
      objects_.push_back(std::make_unique<Object>());
      return static_cast<std::uint32_t>(objects_.size() - 1);
    }
    const std::uint32_t index = free_.back();
    free_.pop_back();
    return index;
  }
  void give_back(std::uint32_t index) {
    Object* const object = objects_[index].get();
    std::destroy_at(object);
    ::new (static_cast<void*>(object)) Object;
    free_.push_back(index);
  }
  Object& operator[](std::uint32_t index) { return *objects_[index]; }
  /// All objects; those that are not in use are as new.
  template <typename Visit>
  void for_each(Visit visit) const {
    for (const auto& object : objects_) {
      visit(*object);
    }
  }
  [[nodiscard]] std::size_t in_use() const { return objects_.size() - free_.size(); }

 private:
  std::vector<std::unique_ptr<Object>> objects_;
  std::vector<std::uint32_t> free_;
};

}  // namespace mbgate::gateway
