// SPDX-License-Identifier: Apache-2.0
#include "app/configuration/digest.hpp"

#include <gtest/gtest.h>

namespace mbgate::app {
namespace {

// printf abc | sha256sum
constexpr const char* kOfAbc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

TEST(ConfigDigest, IsThatOfAllFilesOneBehindTheOther) {
  EXPECT_EQ(config_digest({{"mbgate.toml", "a"}, {"conf.d/b.toml", ""}, {"p.toml", "bc"}}), kOfAbc);
}

TEST(ConfigDigest, IsTheOneOfItsCommand) {
  EXPECT_EQ(digest_command({{"/etc/mbgate/mbgate.toml", ""}, {"/p/moons.toml", ""}}),
            "cat /etc/mbgate/mbgate.toml /p/moons.toml | sha256sum");
  EXPECT_EQ(digest_command({{"a b.toml", ""}, {"it's.toml", ""}}),
            R"(cat 'a b.toml' 'it'\''s.toml' | sha256sum)");
}

}  // namespace
}  // namespace mbgate::app
