// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "routing/client_address.hpp"

namespace mbgate::routing {
namespace {

using Der = std::vector<std::uint8_t>;

Der utf8_string(const std::string& text) {
  Der der = {0x0C};
  if (text.size() >= 128) {
    der.push_back(0x81);
  }
  der.push_back(static_cast<std::uint8_t>(text.size()));
  der.insert(der.end(), text.begin(), text.end());
  return der;
}

ClientRole role_of_one(const Der& der) {
  const std::vector<modbus::Bytes> values = {der};
  return role_of(values);
}

ClientRole named(const std::string& name) { return {ClientRole::Kind::named, name}; }
const ClientRole kUnreadable{ClientRole::Kind::unreadable, {}};

TEST(RoleExtension, IsTheWholeString) {
  EXPECT_EQ(role_of_one({0x0C, 0x08, 'O', 'p', 'e', 'r', 'a', 't', 'o', 'r'}), named("Operator"));
  EXPECT_EQ(role_of_one(utf8_string("A, B")), named("A, B"));
  EXPECT_EQ(role_of_one(utf8_string(std::string("a\0b", 3))), named(std::string("a\0b", 3)));
}

TEST(RoleExtension, IsTheNullRoleWhereThereIsNone) { EXPECT_EQ(role_of({}), named("")); }

TEST(RoleExtension, IsUnreadableWhereItIsEmptyOrThereTwice) {
  EXPECT_EQ(role_of_one(utf8_string("")), kUnreadable);
  EXPECT_EQ(role_of_one({}), kUnreadable);
  const Der one = utf8_string("Operator");
  const std::vector<modbus::Bytes> twice = {one, one};
  EXPECT_EQ(role_of(twice), kUnreadable);
}

TEST(RoleExtension, IsUnreadableInAnotherType) {
  EXPECT_EQ(role_of_one({0x13, 0x01, 'A'}), kUnreadable);              // PrintableString
  EXPECT_EQ(role_of_one({0x2C, 0x03, 0x0C, 0x01, 'A'}), kUnreadable);  // in pieces, as BER allows
  EXPECT_EQ(role_of_one({0x30, 0x03, 0x0C, 0x01, 'A'}), kUnreadable);  // SEQUENCE
}

TEST(RoleExtension, HasOneLengthInDer) {
  EXPECT_EQ(role_of_one(utf8_string(std::string(127, 'r'))), named(std::string(127, 'r')));
  EXPECT_EQ(role_of_one(utf8_string(std::string(128, 'r'))), named(std::string(128, 'r')));
  EXPECT_EQ(role_of_one(utf8_string(std::string(255, 'r'))), named(std::string(255, 'r')));
  EXPECT_EQ(role_of_one({0x0C, 0x81, 0x01, 'A'}), kUnreadable);        // longer than needed
  EXPECT_EQ(role_of_one({0x0C, 0x82, 0x00, 0x01, 'A'}), kUnreadable);  // longer still
  EXPECT_EQ(role_of_one({0x0C, 0x80, 'A', 0x00, 0x00}), kUnreadable);  // without end, as in BER
  EXPECT_EQ(role_of_one({0x0C, 0x02, 'A'}), kUnreadable);              // cut
  EXPECT_EQ(role_of_one({0x0C, 0x01, 'A', 'B'}), kUnreadable);         // something behind it
  EXPECT_EQ(role_of_one({0x0C}), kUnreadable);
  Der longest = {0x0C, 0x82, 0x01, 0x00};
  longest.resize(4 + 256, 'r');
  EXPECT_EQ(role_of_one(longest), kUnreadable);
}

TEST(RoleExtension, IsUtf8) {
  EXPECT_EQ(role_of_one(utf8_string("\xC3\x84")), named("\xC3\x84"));
  EXPECT_EQ(role_of_one(utf8_string("\xE2\x82\xAC")), named("\xE2\x82\xAC"));
  EXPECT_EQ(role_of_one(utf8_string("\xF0\x9F\x94\x91")), named("\xF0\x9F\x94\x91"));
  for (const std::string wrong :
       {"\x80", "\xC3", "\xC3(", "\xC0\x80", "\xC1\xBF", "\xE0\x80\xAF", "\xED\xA0\x80",
        "\xF0\x80\x80\xAF", "\xF4\x90\x80\x80", "\xF8\x88\x80\x80\x80", "\xFF", "A\xE2\x82"}) {
    EXPECT_EQ(role_of_one(utf8_string(wrong)), kUnreadable);
  }
}

}  // namespace
}  // namespace mbgate::routing
