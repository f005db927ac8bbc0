// SPDX-License-Identifier: Apache-2.0
// Every file in tests/config: valid ones give settings, with the warnings of the file beside it, if
// there is one; invalid ones give exactly the text beside them and no settings.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "support/config_text.hpp"

namespace mbgate::config::load_test {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

const fs::path kFolder = fs::path(MBGATE_SOURCE_DIR) / "tests/config";

std::string text_of(const fs::path& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

std::vector<fs::path> cases(const std::string& kind) {
  std::set<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kFolder / kind)) {
    if (entry.path().extension() == ".toml") {
      files.insert(entry.path());
    }
  }
  return {files.begin(), files.end()};
}

std::string case_name(const testing::TestParamInfo<fs::path>& info) {
  std::string name = info.param.stem().string();
  std::ranges::replace_if(
      name, [](char c) { return c == '-' || c == '.'; }, '_');
  return name;
}

/// The diagnostics name the file without its folder, so that the expected texts hold in every
/// checkout.
Loaded load(const fs::path& path) {
  return test::load_settings_text(path.filename().string(), text_of(path),
                                  {.otherwise = {kFolder / "profiles"}});
}

fs::path expected_of(fs::path path) { return path.replace_extension(".expected"); }

class ValidFile : public testing::TestWithParam<fs::path> {};

TEST_P(ValidFile, GivesSettingsAndTheExpectedWarnings) {
  const auto loaded = load(GetParam());
  EXPECT_EQ(render(loaded.diagnostics), text_of(expected_of(GetParam())));
  EXPECT_TRUE(loaded.settings);
}

INSTANTIATE_TEST_SUITE_P(Files, ValidFile, testing::ValuesIn(cases("valid")), case_name);

class InvalidFile : public testing::TestWithParam<fs::path> {};

TEST_P(InvalidFile, GivesExactlyTheExpectedText) {
  const auto loaded = load(GetParam());
  ASSERT_TRUE(fs::exists(expected_of(GetParam())));
  EXPECT_EQ(render(loaded.diagnostics), text_of(expected_of(GetParam())));
  EXPECT_FALSE(loaded.settings);
}

INSTANTIATE_TEST_SUITE_P(Files, InvalidFile, testing::ValuesIn(cases("invalid")), case_name);

TEST(TestFiles, AreAllThere) {
  EXPECT_GE(cases("invalid").size(), 25U);
  EXPECT_GE(cases("valid").size(), 4U);
}

TEST(LoadSettings, NamesTheFileAsItWasGiven) {
  const auto path = kFolder / "invalid/unknown-keys.toml";
  const auto loaded = load_settings(path);
  ASSERT_FALSE(loaded.diagnostics.empty());
  EXPECT_EQ(loaded.diagnostics[0].file, path.string());
  EXPECT_FALSE(loaded.settings);
}

TEST(LoadSettings, TakesOneAddressOfHttpWithoutAList) {
  const auto loaded = test::load_settings_text(
      "x.toml", text_of(kFolder / "valid/minimal.toml") + "[http]\nlisten = \"[::1]:8080\"\n");
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->http.listen,
            std::vector{*routing::ListenAddress::parse("[::1]:8080")});
  EXPECT_EQ(loaded.settings->http.allow, routing::loopback_networks());
}

TEST(LoadSettings, FillsListenersAndBuses) {
  const auto loaded = load(kFolder / "valid/every-key.toml");
  ASSERT_TRUE(loaded.settings);
  const auto& settings = *loaded.settings;
  EXPECT_EQ(settings.status_unit, 200);
  EXPECT_TRUE(settings.lock_memory);
  EXPECT_TRUE(settings.audit);
  EXPECT_EQ(settings.wake_early, 20us);
  EXPECT_EQ(settings.control_socket, "/run/other/control");
  EXPECT_EQ(settings.http,
            (gateway::HttpSettings{.listen = {*routing::ListenAddress::parse("127.0.0.1:0"),
                                              *routing::ListenAddress::parse("[fd00::7]:8080")},
                                   .allow = {*routing::Network::parse("127.0.0.1"),
                                             *routing::Network::parse("fd00::/64")},
                                   .hosts = {"gateway.plant"},
                                   .max_streams = 3,
                                   .client_metrics = true}));
  const auto& routed = settings.listeners.at(1);
  EXPECT_EQ(routed.name, "plant");
  EXPECT_EQ(routed.address, "::1");
  EXPECT_EQ(routed.port, 0);
  EXPECT_TRUE(routed.freebind);
  EXPECT_EQ(routed.max_connections, 8U);
  EXPECT_EQ(routed.max_connections_per_address, 6U);
  EXPECT_EQ(routed.max_connects_per_second, 0U);
  EXPECT_EQ(routed.max_requests_per_second, 500U);
  EXPECT_EQ(routed.pipeline, 4U);
  EXPECT_TRUE(routed.ordered);
  EXPECT_EQ(routed.give_up, 8s);
  EXPECT_TRUE(routed.one_at_a_time);
  EXPECT_EQ(routed.idle_timeout, 10min);
  EXPECT_EQ(routed.frame_timeout, 5s);
  EXPECT_EQ(routed.allow.size(), 2U);
  EXPECT_TRUE(contains(routed.read_only.networks, *routing::ClientAddress::parse("192.168.10.77")));
  EXPECT_TRUE(contains(routed.keep.networks, *routing::ClientAddress::parse("192.168.10.5")));
  EXPECT_FALSE(routed.bus);
  EXPECT_EQ(routed.tcp.keepalive_idle, 0s);
  EXPECT_EQ(routed.tcp.keepalive_interval, 5s);
  EXPECT_EQ(routed.tcp.keepalive_probes, 2U);
  EXPECT_EQ(routed.tcp.user_timeout, 1500ms);
  EXPECT_EQ(routed.tcp.backlog, 16U);
  const auto& transparent = settings.listeners.at(2);
  EXPECT_EQ(transparent.bus, drive::BusId{1});
  EXPECT_TRUE(transparent.broadcast);
  EXPECT_EQ(transparent.broadcast_reply, routing::BroadcastReply::none);
  const auto& bus = settings.buses.at(0);
  EXPECT_EQ(bus.line.device, "/dev/ttyS0");
  EXPECT_EQ(bus.line.baud, modbus::Baud{9600});
  EXPECT_EQ(bus.line.format, (modbus::CharacterFormat{8, modbus::Parity::odd, 2}));
  EXPECT_EQ(bus.line.rs485, bus::Rs485::rts);
  EXPECT_EQ(bus.line.echo, true);
  EXPECT_FALSE(bus.line.low_latency);
  EXPECT_EQ(bus.timing.response_timeout, 250ms);
  EXPECT_EQ(bus.timing.retries, 2U);
  EXPECT_EQ(bus.turnaround, 150ms);
  EXPECT_EQ(bus.frame_gap, 5ms);
  EXPECT_EQ(bus.frame_slack, 30ms);
  EXPECT_EQ(bus.listen_first, 0s);
  EXPECT_EQ(bus.settle, 1ms);
  EXPECT_EQ(bus.queue, 10U);
  EXPECT_EQ(bus.burst, 3U);
  EXPECT_EQ(bus.stop_wait, 50ms);
  EXPECT_EQ(bus.stop_deadline, 3s);
  EXPECT_FALSE(bus.coalesce);
  EXPECT_EQ(bus.probe_share, 5U);
  EXPECT_EQ(bus.reopen_min, 200ms);
  EXPECT_EQ(bus.reopen_max, 2s);
  EXPECT_EQ(bus.hung_after, 1min);
  EXPECT_EQ(bus.hung_requests, 20U);
  EXPECT_EQ(bus.hung_max, 5min);
}

TEST(LoadSettings, FillsCertificatesAndListenersThatUseThem) {
  const auto loaded =
      test::load_settings_text("/etc/mbgate/mbgate.toml", text_of(kFolder / "valid/every-key.toml"),
                               {.otherwise = {kFolder / "profiles"}});
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->signer, "/run/other/signer");
  EXPECT_THAT(loaded.settings->tls,
              testing::ElementsAre(gateway::TlsSettings{.name = "gate",
                                                        .certificate = "/etc/mbgate/certs/gate.crt",
                                                        .key = "gate.key",
                                                        .authorities = "/etc/plant/ca.crt",
                                                        .crl = "/etc/mbgate/ca.crl"}));
  const auto& secure = loaded.settings->listeners.at(0);
  EXPECT_EQ(secure.tls, 0U);
  EXPECT_EQ(secure.port, 802);
  EXPECT_EQ(secure.handshakes, (gateway::HandshakeSettings{.timeout = 3s,
                                                           .hello = 1s,
                                                           .at_a_time = 12,
                                                           .for_one_client = 2,
                                                           .per_second = 50,
                                                           .per_second_for_one_client = 5}));
  EXPECT_FALSE(loaded.settings->listeners.at(1).tls);
}

TEST(LoadSettings, FillsTheDirectionControlOfTheKernel) {
  const auto loaded = load(kFolder / "valid/rs485-kernel.toml");
  ASSERT_TRUE(loaded.settings);
  const auto& line = loaded.settings->buses.at(0).line;
  EXPECT_EQ(line.rs485, bus::Rs485::kernel);
  EXPECT_EQ(line.rs485_rts_on_send, false);
  EXPECT_EQ(line.rs485_delay_before, 1ms);
  EXPECT_EQ(line.rs485_delay_after, 100ms);
}

TEST(LoadSettings, LetsADeviceInheritFromItsBus) {
  const auto loaded = load(kFolder / "valid/every-key.toml");
  ASSERT_TRUE(loaded.settings);
  const auto& own = loaded.settings->devices.at(0);
  EXPECT_EQ(own.bus, drive::BusId{0});
  EXPECT_EQ(own.address, 7);
  EXPECT_EQ(own.timing.response_timeout, 100ms);
  EXPECT_EQ(own.timing.response_wait, 20ms);
  EXPECT_EQ(own.timing.gap, 3ms);
  EXPECT_EQ(own.timing.gap_after_write, 30ms);
  EXPECT_EQ(own.timing.retries, 3U);
  EXPECT_TRUE(own.timing.retry_writes);
  const auto& inherited = loaded.settings->devices.at(1);
  EXPECT_EQ(inherited.timing.response_timeout, 250ms);
  EXPECT_EQ(inherited.timing.retries, 2U);
  EXPECT_FALSE(inherited.timing.retry_writes);
}

TEST(LoadSettings, FillsRoutesToDevicesAndAddresses) {
  const auto loaded = load(kFolder / "valid/every-key.toml");
  ASSERT_TRUE(loaded.settings);
  const auto& to_device = loaded.settings->routes.at(0);
  EXPECT_EQ(to_device.listener, routing::ListenerId{1});
  EXPECT_EQ(to_device.first_unit, 1);
  EXPECT_EQ(to_device.last_unit, 1);
  EXPECT_THAT(to_device.buses, testing::ElementsAre(drive::BusId{0}));
  EXPECT_EQ(to_device.first_address, 7);
  EXPECT_EQ(to_device.access, routing::Access::read_only);
  EXPECT_EQ(to_device.deadline, 4s);
  EXPECT_EQ(to_device.functions.allowed.count(), 2U);
  EXPECT_FALSE(to_device.functions.allowed.test(8));
  EXPECT_TRUE(to_device.functions.restart_communications);
  EXPECT_FALSE(to_device.functions.force_listen_only);
  const auto& range = loaded.settings->routes.at(1);
  EXPECT_FALSE(range.listener);
  EXPECT_EQ(range.first_unit, 100);
  EXPECT_EQ(range.last_unit, 131);
  EXPECT_THAT(range.buses, testing::ElementsAre(drive::BusId{1}));
  EXPECT_EQ(range.first_address, 1);
  EXPECT_EQ(range.functions.allowed, routing::FunctionRules::all().allowed);
  const auto& same = loaded.settings->routes.at(2);
  EXPECT_EQ(same.first_unit, 40);
  EXPECT_EQ(same.first_address, 40);
}

TEST(LoadSettings, FillsWindowsAndBroadcasts) {
  const auto loaded = load(kFolder / "valid/every-key.toml");
  ASSERT_TRUE(loaded.settings);
  const auto& windowed = loaded.settings->routes.at(3);
  ASSERT_EQ(windowed.windows.size(), 1U);
  EXPECT_EQ(windowed.windows[0].table, modbus::Table::input_registers);
  EXPECT_EQ(windowed.windows[0].from, 0);
  EXPECT_EQ(windowed.windows[0].count, 65536U);
  EXPECT_EQ(windowed.windows[0].to, 0);
  EXPECT_EQ(windowed.functions.allowed, routing::FunctionRules::rewritable().allowed);
  const auto& broadcast = loaded.settings->routes.at(4);
  EXPECT_TRUE(broadcast.is_broadcast());
  EXPECT_THAT(broadcast.buses, testing::ElementsAre(drive::BusId{0}, drive::BusId{1}));
  EXPECT_EQ(broadcast.broadcast_reply, routing::BroadcastReply::none);
  EXPECT_EQ(broadcast.functions.allowed.count(), 2U);
}

TEST(LoadSettings, TurnsTheOwnUnitOff) {
  const auto loaded = load(kFolder / "valid/own-unit-off.toml");
  ASSERT_TRUE(loaded.settings);
  EXPECT_FALSE(loaded.settings->status_unit);
  EXPECT_EQ(loaded.settings->routes.at(0).first_unit, 255);
}

}  // namespace
}  // namespace mbgate::config::load_test
