// SPDX-License-Identifier: Apache-2.0
#include "bus/cut_frame.hpp"

#include "bus/rtu_shape.hpp"
#include "modbus/request_length.hpp"
#include "modbus/response.hpp"

namespace mbgate::bus {
namespace {

bool may_begin_frame(modbus::Bytes bytes) {
  const bool has_unit =
      bytes[0] != modbus::kBroadcastAddress && bytes[0] <= modbus::kMaxDeviceAddress;
  return has_unit && (may_become_whole(bytes, modbus::response_length(bytes.subspan(1))) ||
                      may_become_whole(bytes, modbus::request_length(bytes.subspan(1))));
}

}  // namespace

void CutFrame::keep(modbus::Bytes bytes, Instant last, Duration slack) {
  if (last - last_ <= slack && kept_.size() + bytes.size() <= kept_.capacity()) {
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

std::optional<CutFrame::Joined> CutFrame::complete(modbus::Bytes bytes, Instant now,
                                                   Duration slack) {
  if (kept_.empty() || now - last_ > slack) {
    kept_.clear();
    return std::nullopt;
  }
  const std::size_t more = std::min(bytes.size(), kept_.capacity() - kept_.size());
  auto joined = kept_;
  joined.insert(joined.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(more));
  const modbus::Bytes all{joined.data(), joined.size()};
  const modbus::PduLength response = modbus::response_length(all.subspan(1));
  const modbus::PduLength request = modbus::request_length(all.subspan(1));
  const bool good_response = is_good(all, response);
  if (!good_response && !is_good_request(all, request)) {
    return std::nullopt;
  }
  const std::size_t size = (good_response ? response : request).bytes + modbus::kRtuOverhead;
  const std::size_t before = kept_.size();
  kept_.clear();
  if (size <= before) {
    return std::nullopt;  // it was whole already, and was seen or given up
  }
  return Joined{*modbus::decode_rtu(all.first(size)), size - before};
}

}  // namespace mbgate::bus
