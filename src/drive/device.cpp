// SPDX-License-Identifier: Apache-2.0
#include "drive/device.hpp"

namespace mbgate::drive {

DeviceTiming Device::timing_of(const modbus::Request& request) const {
  DeviceTiming times = timing;
  const auto meets = [](const SlowRegisters& slow, const std::optional<modbus::AddressField>& at) {
    return at && overlap(slow.range, at->range);
  };
  for (const SlowRegisters& slow : profile.slow) {
    if (meets(slow, request.reads()) || meets(slow, request.writes())) {
      times.response_timeout = std::max(times.response_timeout, slow.response_timeout);
    }
  }
  return times;
}

bool Device::is_reconfigured_by(const modbus::Request& request,
                                std::optional<WordOrder> order) const {
  return request.writes() &&
         (touches(profile.communication, request.writes()->range) ||
          std::ranges::any_of(profile.guarded, [&](const GuardedWrite& guarded) {
            return may_write(request, guarded, order);
          }));
}

bool Device::is_stop(const modbus::Request& request) const {
  return std::ranges::any_of(profile.stops,
                             [&](const WriteMatch& stop) { return writes_only(request, stop); });
}

bool Device::may_be_stopped_by(const modbus::Request& request) const {
  return request.writes() && std::ranges::any_of(profile.stops, [&](const WriteMatch& stop) {
           const auto written = request.written(stop.address);
           return contains(request.writes()->range, stop.table, stop.address) &&
                  (!written || stop.fits(*written));
         });
}

const std::vector<std::uint16_t>* Device::stated_order() const {
  const auto& setting = profile.word_order_register;
  if (!setting) {
    return nullptr;
  }
  return word_order == WordOrder::big ? &setting->big : &setting->little;
}

std::optional<Duration> Device::silent_after(const modbus::Request& request) const {
  for (const UnansweredWrite& unanswered : profile.unanswered) {
    if (writes(request, unanswered.match)) {
      return unanswered.after;
    }
  }
  return std::nullopt;
}

}  // namespace mbgate::drive
