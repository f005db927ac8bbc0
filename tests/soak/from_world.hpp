// SPDX-License-Identifier: Apache-2.0
// What the soak has from the world that will replace it: chance, time, the clumsy driver, and the
// hosts that clients come from.
#pragma once

#include "world/driver.hpp"
#include "world/hosts.hpp"

namespace mbgate::soak {

using bus::Duration;
using bus::Instant;
using world::address_of;
using world::draw_driver;
using world::draw_stops;
using world::Driver;
using world::DriverManners;
using world::kMostHosts;
using world::network_of;
using world::networks_of;
using world::Random;
using world::Schedule;
using world::text_of;

}  // namespace mbgate::soak
