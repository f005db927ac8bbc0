// SPDX-License-Identifier: Apache-2.0
#include "bus/cut_frame.hpp"

#include <algorithm>

#include "bus/rtu_shape.hpp"

namespace mbgate::bus {

void CutFrame::keep(modbus::Bytes bytes, Instant began, Instant last, Duration slack) {
  if (began - last_ <= slack && kept_.size() + bytes.size() <= kept_.capacity()) {
    kept_.insert(kept_.end(), bytes.begin(), bytes.end());
    last_ = last;
    if (may_begin_frame({kept_.data(), kept_.size()})) {
      return;
    }
  }
  kept_.clear();
  if (bytes.size() <= kept_.capacity() && may_begin_frame(bytes)) {
    kept_.assign(bytes.begin(), bytes.end());
    last_ = last;
  }
}

std::optional<CutFrame::Joined> CutFrame::complete(modbus::Bytes bytes, Instant began,
                                                   Duration slack) {
  if (began - last_ > slack) {
    kept_.clear();
  }
  if (kept_.empty() || bytes.empty()) {
    return std::nullopt;
  }
  // A good frame is no rest of another, whatever its bytes make with those.
  if (bytes.size() > 1 && good_frame(bytes)) {
    kept_.clear();
    return std::nullopt;
  }
  const std::size_t more = std::min(bytes.size(), kept_.capacity() - kept_.size());
  auto joined = kept_;
  joined.insert(joined.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(more));
  const modbus::Bytes all{joined.data(), joined.size()};
  const auto frame = good_frame(all);
  if (!frame) {
    return std::nullopt;
  }
  const std::size_t before = kept_.size();
  kept_.clear();
  if (frame->size <= before) {
    return std::nullopt;  // it was whole already, and was seen or given up
  }
  return Joined{*modbus::decode_rtu(all.first(frame->size)), frame->size - before};
}

}  // namespace mbgate::bus
