// SPDX-License-Identifier: Apache-2.0
#include "gateway/settings.hpp"

#include <algorithm>
#include <iterator>

namespace mbgate::gateway {

std::vector<drive::Device> Settings::devices_on(BusId bus) const {
  std::vector<drive::Device> found;
  std::ranges::copy_if(devices, std::back_inserter(found),
                       [bus](const drive::Device& device) { return device.bus == bus; });
  return found;
}

}  // namespace mbgate::gateway
