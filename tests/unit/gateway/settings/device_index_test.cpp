// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "gateway/settings/settings_snapshot.hpp"

namespace mbgate::gateway {
namespace {

// Some servers on TCP know their drive by this one only.
TEST(DeviceIndex, KnowsADeviceAtUnitIdentifierZero) {
  const drive::Device device{"axis", drive::BusId{0}, 0, {}};
  const DeviceIndex index({&device, 1}, 1);
  EXPECT_EQ(index.at(drive::BusId{0}, 0), 0U);
  EXPECT_EQ(index.at(drive::BusId{0}, 1), std::nullopt);
}

}  // namespace
}  // namespace mbgate::gateway
