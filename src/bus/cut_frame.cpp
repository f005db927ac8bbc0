// SPDX-License-Identifier: Apache-2.0
#include "bus/cut_frame.hpp"

#include <algorithm>

#include "bus/rtu_shape.hpp"

namespace mbgate::bus {

void CutFrame::keep(modbus::Bytes bytes, Instant began, Instant last, Duration slack) {
  if (began - last_ > slack || kept_.size() + bytes.size() > kept_.capacity()) {
    kept_.clear();
  }
  if (bytes.size() <= kept_.capacity()) {
    kept_.insert(kept_.end(), bytes.begin(), bytes.end());
    last_ = last;
  }
  while (!kept_.empty() && !may_begin_frame({kept_.data(), kept_.size()})) {
    kept_.erase(kept_.begin());
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
  const std::size_t before = kept_.size();
  for (std::size_t at = 0; at < before && at <= kMostNoise; ++at) {
    const modbus::Bytes all = modbus::Bytes(joined.data(), joined.size()).subspan(at);
    if (const auto frame = good_frame(all); frame && (at == 0 || !is_exception(all))) {
      kept_.clear();
      if (at + frame->size <= before) {
        return std::nullopt;  // it was whole already, and was seen or given up
      }
      return Joined{*modbus::decode_rtu(all.first(frame->size)), at + frame->size - before,
                    frame->is_response, at > 0};
    }
  }
  return std::nullopt;
}

}  // namespace mbgate::bus
