// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "bus/serial/rtu_framer.hpp"
#include "bus/serial/rtu_shape.hpp"

namespace mbgate::bus {

// The oldest pieces go: a frame that begins so far back would be longer than any.
void CutFrame::make_room(std::size_t size) {
  const std::size_t room = kept_.capacity() - size;
  std::size_t count = kept_.size() - std::min(kept_.size(), room);
  while (count > 0 && count < kept_.size() && !begins_[count]) {
    ++count;
  }
  kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(count));
  begins_ >>= count;
}

void CutFrame::keep(modbus::Bytes bytes, Instant began, Instant last) {
  if (began - last_ > kLongestPauses || bytes.size() > kept_.capacity()) {
    *this = {};
  }
  if (bytes.size() <= kept_.capacity()) {
    pause_ = kept_.empty() ? Duration{0} : std::max(pause_, began - last_);
    make_room(bytes.size());
    begins_.set(kept_.size());
    kept_.insert(kept_.end(), bytes.begin(), bytes.end());
    last_ = last;
  }
  while (!kept_.empty() && !may_begin_frame({kept_.data(), kept_.size()})) {
    kept_.erase(kept_.begin());
    begins_ >>= 1;
    begins_.set(0);
  }
}

CutFrame::Together CutFrame::joined_with(modbus::Bytes bytes) const {
  Together joined(kept_.begin(), kept_.end());
  const modbus::Bytes rest = bytes.first(std::min(bytes.size(), modbus::kMaxRtuSize));
  joined.insert(joined.end(), rest.begin(), rest.end());
  return joined;
}

bool CutFrame::may_go_on(modbus::Bytes bytes, Instant began, Duration slack) const {
  if (kept_.empty() || began - last_ > slack) {
    return false;
  }
  const auto joined = joined_with(bytes);
  return may_begin_frame({joined.data(), joined.size()});
}

std::optional<CutFrame::Joined> CutFrame::complete(modbus::Bytes bytes, Instant began) {
  if (began - last_ > kLongestPauses) {
    *this = {};
  }
  if (kept_.empty() || bytes.empty()) {
    return std::nullopt;
  }
  // A good frame is no rest of another, whatever its bytes make with those.
  if (bytes.size() > 1 && good_frame(bytes)) {
    *this = {};
    return std::nullopt;
  }
  const auto joined = joined_with(bytes);
  const std::size_t before = kept_.size();
  std::size_t noise = 0;  // since a piece began
  for (std::size_t at = 0; at < before && at + 1 < joined.size(); ++at) {
    noise = begins_[at] ? 0 : noise + 1;
    const modbus::Bytes all = modbus::Bytes(joined.data(), joined.size())
                                  .subspan(at, std::min(joined.size() - at, modbus::kMaxRtuSize));
    const auto frame = noise > kMostNoise ? std::nullopt : good_frame(all);
    if (!frame || (noise > 0 && is_exception(all))) {
      continue;
    }
    const Duration pause = std::max(pause_, began - last_);
    *this = {};
    if (at + frame->size <= before) {
      return std::nullopt;  // it was whole already, and was seen or given up
    }
    return Joined{*modbus::decode_rtu(all.first(frame->size)), at + frame->size - before,
                  frame->is_response, noise > 0, pause};
  }
  return std::nullopt;
}

}  // namespace mbgate::bus
