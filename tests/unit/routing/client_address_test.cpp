// SPDX-License-Identifier: Apache-2.0
#include "routing/client_address.hpp"

#include <gtest/gtest.h>

namespace mbgate::routing {
namespace {

using namespace std::string_view_literals;

ClientAddress address(std::string_view text) { return ClientAddress::parse(text).value(); }
Network network(std::string_view text) { return Network::parse(text).value(); }

TEST(ClientAddress, TextIsTheShortestForm) {
  EXPECT_EQ(address("192.168.10.5").to_text(), "192.168.10.5");
  EXPECT_EQ(address("fe80::1").to_text(), "fe80::1");
  EXPECT_EQ(address("FE80:0:0:0:0:0:0:1").to_text(), "fe80::1");
  EXPECT_EQ(address("0.0.0.0").to_text(), "0.0.0.0");
  EXPECT_EQ(address("::").to_text(), "::");
  EXPECT_EQ(address("::1").to_text(), "::1");
  EXPECT_EQ(ClientAddress().to_text(), "::");
}

TEST(ClientAddress, V4IsTheSameClientOnAnIpv6Socket) {
  EXPECT_EQ(address("::ffff:10.0.0.7"), address("10.0.0.7"));
  EXPECT_EQ(address("::ffff:10.0.0.7").to_text(), "10.0.0.7");
  EXPECT_TRUE(address("10.0.0.7").is_v4());
  EXPECT_TRUE(address("::ffff:a00:7").is_v4());
  EXPECT_FALSE(address("::1").is_v4());
  EXPECT_FALSE(address("::10.0.0.7").is_v4());
  EXPECT_FALSE(address("::ff:a00:7").is_v4());
  EXPECT_FALSE(address("::ff00:a00:7").is_v4());
  EXPECT_FALSE(address("2001:db8::ffff:a00:7").is_v4());
  EXPECT_FALSE(address("::1:ffff:a00:7").is_v4());
}

TEST(ClientAddress, OctetsAreInNetworkOrderBehindTheMappingPrefix) {
  EXPECT_EQ(address("1.2.3.4").octets(),
            (ClientAddress::Octets{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 1, 2, 3, 4}));
  EXPECT_EQ(ClientAddress(address("fe80::1").octets()), address("fe80::1"));
}

TEST(ClientAddress, OrderIsTotal) {
  EXPECT_LT(address("10.0.0.1"), address("10.0.0.2"));
  EXPECT_NE(address("10.0.0.1"), address("::10.0.0.1"));
}

TEST(ClientAddress, RefusesWhatIsNoAddress) {
  for (const auto text :
       {""sv, " "sv, "10.0.0"sv, "10.0.0.256"sv, "10.0.0.1.2"sv, "010.0.0.1"sv, "10.0.0.1 "sv,
        " 10.0.0.1"sv, "10.0.0.1/8"sv, "localhost"sv, "fe80::1%eth0"sv, ":::"sv, "1:2:3:4:5:6:7"sv,
        "12345::"sv, "[::1]"sv, "10.0.0.1:502"sv}) {
    EXPECT_FALSE(ClientAddress::parse(text).has_value()) << text;
  }
}

TEST(ClientAddress, RefusesBytesBehindAZero) {
  EXPECT_FALSE(ClientAddress::parse("10.0.0.1\0x"sv).has_value());
  EXPECT_FALSE(ClientAddress::parse("::1\0"sv).has_value());
}

TEST(Network, ContainsItsAddressesAndNoOthers) {
  EXPECT_TRUE(network("192.168.10.0/24").contains(address("192.168.10.0")));
  EXPECT_TRUE(network("192.168.10.0/24").contains(address("192.168.10.255")));
  EXPECT_FALSE(network("192.168.10.0/24").contains(address("192.168.11.0")));
  EXPECT_FALSE(network("192.168.10.0/24").contains(address("192.168.9.255")));
  EXPECT_TRUE(network("fe80::/10").contains(address("febf::1")));
  EXPECT_FALSE(network("fe80::/10").contains(address("fec0::1")));
}

TEST(Network, PrefixesNeedNotEndAtAByte) {
  const Network half = network("10.0.0.128/25");
  EXPECT_FALSE(half.contains(address("10.0.0.127")));
  EXPECT_TRUE(half.contains(address("10.0.0.128")));
  EXPECT_TRUE(half.contains(address("10.0.0.255")));
  const Network pair = network("10.0.0.6/31");
  EXPECT_FALSE(pair.contains(address("10.0.0.5")));
  EXPECT_TRUE(pair.contains(address("10.0.0.6")));
  EXPECT_TRUE(pair.contains(address("10.0.0.7")));
  EXPECT_FALSE(pair.contains(address("10.0.0.8")));
}

TEST(Network, WithoutPrefixIsOneAddress) {
  EXPECT_TRUE(network("10.0.0.7").contains(address("10.0.0.7")));
  EXPECT_FALSE(network("10.0.0.7").contains(address("10.0.0.6")));
  EXPECT_TRUE(network("10.0.0.7/32").contains(address("10.0.0.7")));
  EXPECT_TRUE(network("::1").contains(address("::1")));
  EXPECT_FALSE(network("::1/128").contains(address("::2")));
}

TEST(Network, ContainsNarrowerOnesAndItself) {
  EXPECT_TRUE(network("10.0.0.0/8").contains(network("10.1.0.0/16")));
  EXPECT_TRUE(network("10.0.0.0/8").contains(network("10.0.0.0/8")));
  EXPECT_TRUE(network("10.0.0.7").contains(network("10.0.0.7/32")));
  EXPECT_FALSE(network("10.1.0.0/16").contains(network("10.0.0.0/8")));
  EXPECT_FALSE(network("10.0.0.0/8").contains(network("11.0.0.0/16")));
  EXPECT_TRUE(network("::/0").contains(network("10.0.0.0/8")));
}

TEST(Network, AllOfV4IsNotAllOfV6) {
  EXPECT_TRUE(network("0.0.0.0/0").contains(address("203.0.113.9")));
  EXPECT_FALSE(network("0.0.0.0/0").contains(address("2001:db8::1")));
  EXPECT_TRUE(network("::/0").contains(address("2001:db8::1")));
  EXPECT_TRUE(network("::/0").contains(address("203.0.113.9")));
}

TEST(Network, MappedFormIsCountedIn128Bits) {
  EXPECT_TRUE(network("::ffff:10.0.0.0/104").contains(address("10.1.2.3")));
  EXPECT_FALSE(network("::ffff:10.0.0.0/104").contains(address("11.1.2.3")));
}

TEST(ClientAddress, IsCountedByTheFirst64BitsOfIpv6) {
  EXPECT_EQ(address("2001:db8:0:7::1").counted_as(), address("2001:db8:0:7:9:9:9:9").counted_as());
  EXPECT_EQ(address("2001:db8:0:7::1").counted_as(), address("2001:db8:0:7:ffff::1").counted_as());
  EXPECT_NE(address("2001:db8:0:7::1").counted_as(), address("2001:db8:0:8::1").counted_as());
  EXPECT_EQ(address("2001:db8:0:7::1").counted_as().to_text(), "2001:db8:0:7::");
}

TEST(ClientAddress, IsCountedByTheWholeAddressOfIpv4) {
  EXPECT_EQ(address("192.168.10.5").counted_as(), address("192.168.10.5"));
  EXPECT_EQ(address("::ffff:192.168.10.5").counted_as(), address("192.168.10.5"));
}

TEST(Network, RefusesBitsBeyondThePrefix) {
  EXPECT_FALSE(Network::parse("192.168.10.5/24").has_value());
  EXPECT_FALSE(Network::parse("10.0.0.1/0").has_value());
  EXPECT_FALSE(Network::parse("10.0.0.7/31").has_value());
  EXPECT_FALSE(Network::parse("fe80::1/64").has_value());
}

TEST(Network, RefusesWhatIsNoNetwork) {
  for (const auto text :
       {""sv, "/"sv, "/8"sv, "10.0.0.0/"sv, "10.0.0.0/33"sv, "10.0.0.0/-1"sv, "10.0.0.0/+8"sv,
        "10.0.0.0/8 "sv, "10.0.0.0/ 8"sv, "10.0.0.0/8x"sv, "10.0.0.0/8/8"sv, "10.0.0.0/255.0.0.0"sv,
        "10/8"sv, "::/129"sv, "10.0.0.0/4294967304"sv, "10.0.0.0/99999999999999999999"sv}) {
    EXPECT_FALSE(Network::parse(text).has_value()) << text;
  }
}

TEST(NetworkList, ContainsWhatOneOfThemContains) {
  const NetworkList list{network("10.0.0.0/8"), network("fe80::/10")};
  EXPECT_TRUE(contains(list, address("10.9.8.7")));
  EXPECT_TRUE(contains(list, address("fe80::9")));
  EXPECT_FALSE(contains(list, address("192.168.0.1")));
  EXPECT_FALSE(contains(NetworkList{}, address("10.9.8.7")));
}

}  // namespace
}  // namespace mbgate::routing
