// SPDX-License-Identifier: Apache-2.0
#include "app/text.hpp"

#include <gtest/gtest.h>

namespace mbgate::app {
namespace {

gateway::Settings settings_of(std::size_t listeners, std::size_t buses) {
  gateway::Settings settings;
  settings.listeners.resize(listeners);
  settings.buses.resize(buses);
  return settings;
}

TEST(StatusText, CountsListenersBusesAndClients) {
  EXPECT_EQ(status_text(settings_of(2, 2), {3, 1}, 0), "2 listeners, 1 of 2 buses open, 3 clients");
  EXPECT_EQ(status_text(settings_of(1, 1), {1, 0}, 0), "1 listener, 0 of 1 bus open, 1 client");
}

TEST(StatusText, CountsListenersThatWaitForTheirAddress) {
  EXPECT_EQ(status_text(settings_of(3, 1), {0, 1}, 2),
            "1 of 3 listeners, 1 of 1 bus open, 0 clients");
}

}  // namespace
}  // namespace mbgate::app
