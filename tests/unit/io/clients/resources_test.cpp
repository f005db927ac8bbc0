// SPDX-License-Identifier: Apache-2.0
#include "io/clients/resources.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace mbgate::io {
namespace {

gateway::Settings plant_of(std::size_t buses, const std::vector<std::size_t>& max_connections) {
  gateway::Settings settings;
  settings.control_socket.clear();
  settings.buses.resize(buses);
  for (const std::size_t connections : max_connections) {
    settings.listeners.emplace_back().max_connections = connections;
  }
  return settings;
}

TEST(DescriptorRoom, SufficesForWhatAllListenersTakeTogether) {
  // 2 listeners, 1 bus: 4 + 32 + 16 + 2 * 3 are not for clients.
  const auto room = room_for_clients(plant_of(1, {300, 200}), 558);
  EXPECT_EQ(room.clients, 500U);
  EXPECT_EQ(room.shortage, std::nullopt);
}

TEST(DescriptorRoom, SaysWhatIsMissing) {
  const auto room = room_for_clients(plant_of(1, {300, 201}), 558);
  EXPECT_EQ(room.clients, 500U);
  EXPECT_EQ(room.shortage,
            "max_connections of all listeners together is 501, but the limit of 558 open files "
            "leaves room for 500 clients: lower it, or raise the limit (LimitNOFILE= of the unit) "
            "to 559");
}

TEST(DescriptorRoom, IsForThePairsOfClientsWithTls) {
  auto settings = plant_of(1, {300, 200});
  settings.tls.emplace_back();
  settings.listeners[1].tls = 0;
  settings.listeners[1].handshakes.at_a_time = 10;
  // 300 + 3 * 200 + 10, and those that are not for clients.
  EXPECT_EQ(room_for_clients(settings, 968).shortage, std::nullopt);
  EXPECT_EQ(room_for_clients(settings, 967).shortage,
            "max_connections of all listeners together is 910 (with TLS each counts three times, "
            "and each of max_handshakes once), but the limit of 967 open files leaves room for 909 "
            "clients: lower it, or raise the limit (LimitNOFILE= of the unit) to 968");
}

TEST(DescriptorRoom, IsForTheHttpInterfaceToo) {
  auto settings = plant_of(1, {300, 200});
  settings.control_socket = "/run/mbgate/control";
  settings.http.max_streams = 10;
  // 1 socket, 64 connections and 10 that follow something.
  EXPECT_EQ(room_for_clients(settings, 633).shortage, std::nullopt);
  settings.http.listen = {*routing::ListenAddress::parse("127.0.0.1:8080"),
                          *routing::ListenAddress::parse("[::1]:8080")};
  const auto room = room_for_clients(settings, 633);
  EXPECT_EQ(room.clients, 575U);
  EXPECT_EQ(room.shortage,
            "max_connections of all listeners together is 500, the HTTP interface may need 143 "
            "more, but the limit of 633 open files leaves room for 575 clients: lower "
            "max_connections or [http] max_streams, or raise the limit (LimitNOFILE= of the unit) "
            "to 701");
  settings.control_socket.clear();
  EXPECT_EQ(room_for_clients(settings, 636).shortage, std::nullopt);  // 2 * 2 + 64 + 10
}

TEST(DescriptorRoom, IsForHttpAtSocketsOfSystemdToo) {
  auto settings = plant_of(1, {300, 200});
  settings.http.max_streams = 10;
  EXPECT_EQ(room_for_clients(settings, 558).shortage, std::nullopt);     // there is no HTTP
  EXPECT_EQ(room_for_clients(settings, 634, 2).shortage, std::nullopt);  // 2 + 64 + 10
  EXPECT_TRUE(room_for_clients(settings, 633, 2).shortage);
  settings.http.listen = {*routing::ListenAddress::parse("127.0.0.1:8080")};
  EXPECT_EQ(room_for_clients(settings, 634, 2).shortage, std::nullopt);  // they take its place
}

TEST(DescriptorRoom, MayBeNoneAtAll) {
  const auto room = room_for_clients(plant_of(20, {1}), 64);
  EXPECT_EQ(room.clients, 0U);
  EXPECT_TRUE(room.shortage);
}

class DescriptorLimit : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before_), 0); }
  void TearDown() override { ::setrlimit(RLIMIT_NOFILE, &before_); }
  rlimit before_{};
};

TEST_F(DescriptorLimit, IsRaisedToTheHardOne) {
  rlimit low = before_;
  low.rlim_cur = 100;
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &low), 0);
  EXPECT_EQ(raise_descriptor_limit(), hard_descriptor_limit());
  rlimit raised{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &raised), 0);
  EXPECT_EQ(raised.rlim_cur, before_.rlim_max);
}

TEST_F(DescriptorLimit, KeepsTheHighestOnesFromClients) {
  rlimit low = before_;
  low.rlim_cur = 100;
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &low), 0);
  EXPECT_EQ(end_of_client_descriptors(plant_of(2, {1})), 60);
  EXPECT_EQ(end_of_client_descriptors(plant_of(20, {1})), 0);
}

}  // namespace
}  // namespace mbgate::io
