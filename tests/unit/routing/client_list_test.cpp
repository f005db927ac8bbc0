// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "routing/client_address.hpp"

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

// A list that may name several is no list of one writer.
TEST(ClientList, NamesOneClientByItsAddressOrItsCertificateAlone) {
  const Network host = Network::parse("192.0.2.5").value();
  const Network other = Network::parse("192.0.2.9").value();
  const Network several = Network::parse("192.0.2.0/24").value();
  struct Case {
    NetworkList networks;
    std::vector<std::string> roles;
    std::vector<std::string> certificates;
    bool names_one;
  };
  for (const Case& it :
       {Case{{host}, {}, {}, true}, Case{{}, {}, {"panel 1"}, true}, Case{{}, {}, {}, false},
        Case{{several}, {}, {}, false}, Case{{host, other}, {}, {}, false},
        Case{{}, {"operator"}, {}, false}, Case{{host}, {"operator"}, {}, false},
        Case{{host}, {}, {"panel 1"}, false}, Case{{}, {}, {"panel 1", "panel 2"}, false}}) {
    ClientList list(it.networks);
    list.roles = it.roles;
    list.certificates = it.certificates;
    EXPECT_EQ(list.names_one(), it.names_one)
        << it.networks.size() << it.roles.size() << it.certificates.size();
  }
}

}  // namespace
}  // namespace mbgate::routing::client_list_test
