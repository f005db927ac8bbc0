// SPDX-License-Identifier: Apache-2.0
// Where the keys stand that deny requests.
#include <gtest/gtest.h>

#include "config/diagnostic.hpp"
#include "support/config_text.hpp"

namespace mbgate::config {
namespace {

constexpr std::string_view kPlaced = R"([[listen]]
name = "plant"
port = 0
allow = ["10.0.0.0/8"]
read_only = [
  "10.0.0.5",
]
[[listen]]
name = "service"
port = 0
[[bus]]
name = "a"
device = "/dev/ttyS0"
[[device]]
name = "x"
bus = "a"
address = 1
writer = ["10.0.0.7"]
[[device]]
name = "y"
bus = "a"
address = 2
[[route]]
unit = 1
device = "x"
access = "read-only"
functions = [3]
[[route.registers]]
table = "holding"
from = 0
count = 4
to = 10
[[route]]
unit = 2
device = "y"
)";

TEST(KeyPlaces, AreThoseOfTheKeysBesideTheSettings) {
  const auto loaded = test::load_settings_text("x.toml", kPlaced);
  ASSERT_TRUE(loaded.settings) << render(loaded.diagnostics);
  const KeyPlaces& places = loaded.places;
  ASSERT_EQ(places.listeners.size(), 2U);
  EXPECT_EQ(places.listeners[0].allow, "x.toml:4");
  EXPECT_EQ(places.listeners[0].read_only, "x.toml:5");
  EXPECT_EQ(places.listeners[1].allow, "");
  EXPECT_EQ(places.listeners[1].read_only, "");
  EXPECT_EQ(places.writers, (std::vector<std::string>{"x.toml:18", ""}));
  ASSERT_EQ(places.routes.size(), 2U);
  EXPECT_EQ(places.routes[0].access, "x.toml:26");
  EXPECT_EQ(places.routes[0].functions, "x.toml:27");
  EXPECT_EQ(places.routes[0].windows, "x.toml:28");
  EXPECT_EQ(places.routes[1].functions, "x.toml:33");
}

TEST(KeyPlaces, AreNoneOfWhatIsWrong) {
  const auto loaded = test::load_settings_text("x.toml", std::string(kPlaced) + "deadline = 5\n");
  EXPECT_FALSE(loaded.settings);
  EXPECT_TRUE(loaded.places.listeners.empty());
}

}  // namespace
}  // namespace mbgate::config
