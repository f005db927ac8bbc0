// SPDX-License-Identifier: Apache-2.0
// What valid/bus-tls.toml says. The invalid files are in load_test.
#include <gtest/gtest.h>

#include "config/load.hpp"

namespace mbgate::config {
namespace {

TEST(BusOverTls, HasTheFilesOfItsSectionAndTheNameOfItsServer) {
  const std::string folder = std::string(MBGATE_SOURCE_DIR) + "/tests/config/valid/";
  const auto loaded = load_settings(folder + "bus-tls.toml", {});
  ASSERT_TRUE(loaded.settings);
  const auto& by_host = loaded.settings->buses.at(0).line;
  EXPECT_EQ(by_host.remote, (bus::Endpoint{"192.168.10.20", 802}));
  const bus::TlsPeer peer{folder + "certs/gateway.crt", "gateway.key",      folder + "certs/ca.crt",
                          folder + "certs/ca.crl",      "/run/keys/socket", "192.168.10.20"};
  EXPECT_EQ(by_host.tls, peer);
  const auto& by_name = loaded.settings->buses.at(1).line;
  EXPECT_EQ(by_name.remote, (bus::Endpoint{"192.168.10.20", 1802}));
  EXPECT_EQ(by_name.tls.value().server_name, "plc.plant");
}

}  // namespace
}  // namespace mbgate::config
