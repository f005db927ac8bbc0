// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/cert_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../parsed_line.hpp"

namespace mbgate::ctl {
namespace {

template <typename Kind>
Kind cert(const std::string& line) {
  return std::get<Kind>(command<CertCommand>("cert " + line));
}

TEST(CertOptions, HaveSensibleDefaults) {
  const auto authority = cert<MakeAuthority>("ca").make;
  EXPECT_EQ(authority.name, "mbgate plant authority");
  EXPECT_EQ(authority.days, 3650U);
  EXPECT_EQ(authority.folder, ".");
  EXPECT_EQ(authority.rsa_bits, std::nullopt);
  EXPECT_FALSE(authority.replace);
  const auto client = cert<MakeClient>("client hmi");
  EXPECT_EQ(client.make.name, "hmi");
  EXPECT_EQ(client.make.days, 825U);
  EXPECT_EQ(client.role, std::nullopt);
  EXPECT_EQ(cert<Revoke>("revoke hmi.crt").days, 365U);
  EXPECT_FALSE(cert<RenewList>("crl").replace);
  EXPECT_EQ(cert<ShowCertificate>("show hmi.crt").file, "hmi.crt");
}

TEST(CertOptions, AreTaken) {
  const auto server = cert<MakeServer>(
      "server gw --address 10.0.0.1 --address gw.plant --days 90 --rsa 3072 --directory /pki "
      "--force");
  EXPECT_THAT(server.addresses, testing::ElementsAre("10.0.0.1", "gw.plant"));
  EXPECT_EQ(server.make.days, 90U);
  EXPECT_EQ(server.make.rsa_bits, 3072U);
  EXPECT_EQ(server.make.folder, "/pki");
  EXPECT_TRUE(server.make.replace);
  EXPECT_EQ(cert<MakeClient>("client hmi --role operator").role, "operator");
}

TEST(CertOptions, AreRefusedWhereTheyMeanNothing) {
  EXPECT_EQ(complaint("cert"), "mbgatectl: A subcommand is required");
  EXPECT_EQ(complaint("cert server gw"), "mbgatectl: --address is required");
  EXPECT_EQ(complaint("cert server gw --address a..b"),
            "mbgatectl: \"a..b\" is neither an IP address nor a host name");
  EXPECT_EQ(complaint("cert client .hidden"),
            "mbgatectl: \".hidden\" names no certificate: it is letters, digits, '-', '.' and '_', "
            "at most 64, such as gateway or hmi-1");
  EXPECT_THAT(complaint("cert ca --rsa 1024"),
              testing::StartsWith("mbgatectl: --rsa: 1024 not in"));
}

}  // namespace
}  // namespace mbgate::ctl
