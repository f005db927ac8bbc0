// SPDX-License-Identifier: Apache-2.0
#include "ctl/cert/role_extension.hpp"

#include <gtest/gtest.h>

#include "ctl/cert/cert_text.hpp"
#include "ctl/cert/certificate.hpp"

namespace mbgate::ctl {
namespace {

using Kind = routing::ClientRole::Kind;

openssl::Certificate certificate_with(const std::optional<std::string>& role) {
  const auto key = make_key(std::nullopt);
  return make_certificate({Purpose::client, "hmi", 1, {}, role}, *key, nullptr);
}

TEST(RoleExtension, IsReadAsItWasMade) {
  for (const std::string role : {"operator", "Operatör", "a \"b\"", "\xE4\xBF\x9D\xE5\x85\xBB"}) {
    EXPECT_EQ(wrong_role(role), "");
    const auto read = read_role(*certificate_with(role));
    EXPECT_EQ(read.kind, Kind::named);
    EXPECT_EQ(read.name, role);
  }
}

TEST(RoleExtension, IsTheNullRoleWhereThereIsNone) {
  const auto read = read_role(*certificate_with(std::nullopt));
  EXPECT_EQ(read.kind, Kind::named);
  EXPECT_EQ(read.name, "");
}

TEST(RoleExtension, IsUnreadableWhereItIsThereTwice) {
  const auto certificate = certificate_with("operator");
  add_role(*certificate, "operator");
  EXPECT_EQ(read_role(*certificate).kind, Kind::unreadable);
}

TEST(RoleExtension, IsTextOfReasonableLength) {
  const std::string why = "a role is UTF-8 text without control characters, of at most 255 bytes";
  EXPECT_EQ(wrong_role(std::string(255, 'r')), "");
  EXPECT_EQ(wrong_role(std::string(256, 'r')), why);
  EXPECT_EQ(wrong_role("a\tb"), why);
  EXPECT_EQ(wrong_role("\xC2\x85"), why);  // a control character of two bytes
  EXPECT_EQ(wrong_role("\xC3("), why);
  EXPECT_EQ(wrong_role("\xC3"), why);
}

TEST(CertificateText, SaysWhenACertificateIsNotValid) {
  const auto certificate = certificate_with("a\\b");
  const auto begin = time_of(*X509_get0_notBefore(certificate.get()));
  const auto end = time_of(*X509_get0_notAfter(certificate.get()));
  const std::string from_to = "  valid      " + time_text(begin) + " to " + time_text(end);
  const auto described_at = [&](Seconds now) { return describe(*certificate, now); };
  EXPECT_NE(described_at(begin - std::chrono::seconds(1)).find(from_to + ": NOT YET VALID\n"),
            std::string::npos);
  EXPECT_NE(described_at(begin).find(from_to + " (1 day left)\n"), std::string::npos);
  EXPECT_NE(described_at(end).find(from_to + " (0 days left)\n"), std::string::npos);
  EXPECT_NE(described_at(end + std::chrono::days(2)).find(from_to + ": EXPIRED 2 days ago\n"),
            std::string::npos);
  EXPECT_NE(described_at(end).find("  role       \"a\\\\b\"\n"), std::string::npos);
}

}  // namespace
}  // namespace mbgate::ctl
