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
  EXPECT_EQ(loaded.places, (KeyPlaces{{{"allow", 0}, "x.toml:4"},
                                      {{"read_only", 0}, "x.toml:5"},
                                      {{"writer", 0}, "x.toml:18"},
                                      {{"access", 0}, "x.toml:26"},
                                      {{"functions", 0}, "x.toml:27"},
                                      {{"windows", 0}, "x.toml:28"},
                                      {{"access", 1}, "x.toml:33"},
                                      {{"functions", 1}, "x.toml:33"},
                                      {{"windows", 1}, "x.toml:33"}}));
}

TEST(KeyPlaces, AreNoneOfWhatIsWrong) {
  const auto loaded = test::load_settings_text("x.toml", std::string(kPlaced) + "deadline = 5\n");
  EXPECT_FALSE(loaded.settings);
  EXPECT_TRUE(loaded.places.empty());
}

}  // namespace
}  // namespace mbgate::config
