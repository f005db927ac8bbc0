// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "routing/client_address.hpp"

namespace mbgate::routing {
namespace {

TEST(ListenAddress, IsAnAddressOfEitherFamilyWithAPort) {
  EXPECT_EQ(ListenAddress::parse("127.0.0.1:8080"),
            (ListenAddress{*ClientAddress::parse("127.0.0.1"), 8080}));
  EXPECT_EQ(ListenAddress::parse("[::1]:0"), (ListenAddress{*ClientAddress::parse("::1"), 0}));
  EXPECT_EQ(ListenAddress::parse("[fd00::7]:65535"),
            (ListenAddress{*ClientAddress::parse("fd00::7"), 65535}));
}

TEST(ListenAddress, IsNothingElse) {
  for (const char* text : {"", ":", "8080", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536",
                           "127.0.0.1:-1", "localhost:8080", "::1:8080", "[::1]", "[]:8080",
                           "[127.0.0.1]:8080", "[:8080", "127.0.0.1 :8080"}) {
    EXPECT_FALSE(ListenAddress::parse(text)) << text;
  }
}

TEST(ListenAddress, OfLoopbackIsReachedByThisMachineAlone) {
  for (const char* text : {"127.0.0.1", "127.8.0.1", "::1", "::ffff:127.0.0.1"}) {
    EXPECT_TRUE(is_loopback(*ClientAddress::parse(text))) << text;
  }
  for (const char* text : {"0.0.0.0", "128.0.0.1", "192.168.10.2", "::", "::2", "fe80::1"}) {
    EXPECT_FALSE(is_loopback(*ClientAddress::parse(text))) << text;
  }
}

}  // namespace
}  // namespace mbgate::routing
