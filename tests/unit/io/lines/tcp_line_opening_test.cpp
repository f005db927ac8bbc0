// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "io/clients/listening_socket.hpp"
#include "io/lines/tcp_line.hpp"

namespace mbgate::io {
namespace {

TEST(HostAddresses, AreNamedAsInAUrl) {
  EXPECT_EQ(to_text(bus::Endpoint{"drive.plant", 502}), "tcp://drive.plant:502");
  EXPECT_EQ(to_text(bus::Endpoint{"::1", 4001}), "tcp://[::1]:4001");
}

TEST(HostAddresses, AreKnownAtOnceWhenTheyAreNumbers) {
  EXPECT_EQ(to_text(*numeric_endpoint({"192.0.2.1", 502})), "192.0.2.1:502");
  EXPECT_EQ(to_text(*numeric_endpoint({"2001:db8::1", 502})), "[2001:db8::1]:502");
  EXPECT_FALSE(numeric_endpoint({"drive.plant", 502}));
}

TEST(HostAddresses, AreFoundByName) {
  // A form of 127.0.0.1 that is no number to numeric_endpoint(), but one to every resolver.
  const auto addresses = resolve({"127.1", 4001});
  EXPECT_FALSE(numeric_endpoint({"127.1", 4001}));
  ASSERT_TRUE(addresses) << addresses.error();
  ASSERT_FALSE(addresses->empty());
  EXPECT_TRUE(addresses->front().address().is_loopback());
  EXPECT_EQ(addresses->front().port(), 4001);
}

}  // namespace
}  // namespace mbgate::io
