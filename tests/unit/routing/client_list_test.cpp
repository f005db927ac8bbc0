// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "routing/client_role.hpp"

namespace mbgate::routing::client_list_test {
namespace {

const ClientAddress kPlc = ClientAddress::parse("192.0.2.5").value();
const ClientAddress kOther = ClientAddress::parse("192.0.2.9").value();
const ClientRole kNone{};
const ClientRole kOperator{ClientRole::Kind::named, "operator", "panel 1"};
const ClientRole kNullRole{ClientRole::Kind::named, "", "panel 2"};
const ClientRole kUnreadable{ClientRole::Kind::unreadable, "", "panel 3"};

TEST(ClientList, NamesAddresses) {
  const ClientList list{Network::parse("192.0.2.5").value()};
  EXPECT_FALSE(list.empty());
  EXPECT_TRUE(list.contains(kPlc, kNone));
  EXPECT_TRUE(list.contains(kPlc, kOperator));
  EXPECT_FALSE(list.contains(kOther, kNone));
}

TEST(ClientList, NamesRoles) {
  ClientList list;
  list.roles = {"operator"};
  EXPECT_TRUE(list.contains(kOther, kOperator));
  EXPECT_FALSE(list.contains(kOther, kNullRole));
  EXPECT_FALSE(list.contains(kOther, kNone));
  list.roles = {""};
  EXPECT_TRUE(list.contains(kOther, kNullRole));
  EXPECT_FALSE(list.contains(kOther, kUnreadable));
  EXPECT_FALSE(list.contains(kOther, kNone));
}

TEST(ClientList, NamesCertificates) {
  ClientList list;
  list.certificates = {"panel 1", ""};
  EXPECT_TRUE(list.contains(kOther, kOperator));
  EXPECT_FALSE(list.contains(kOther, kNullRole));
  EXPECT_FALSE(list.contains(kOther, kNone));
}

}  // namespace
}  // namespace mbgate::routing::client_list_test
