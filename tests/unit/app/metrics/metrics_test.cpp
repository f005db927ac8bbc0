// SPDX-License-Identifier: Apache-2.0
#include "app/metrics/metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace mbgate::app {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

gateway::StatusReport report() {
  gateway::StatusReport report;
  gateway::BusStatus bus;
  bus.name = "line-a";
  bus.line = "/dev/ttyUSB0";
  bus.baud = modbus::Baud{19200};
  bus.is_open = true;
  bus.busy = 1500ms;
  bus.counters.losses = 2;
  bus.counters.refused_full = 3;
  bus.silences.note(2005us);
  report.buses.push_back(bus);
  gateway::DeviceStatus device;
  device.name = "feeder";
  device.address = 7;
  device.state = bus::DeviceState::offline;
  device.counters.timeouts = 5;
  device.counters.exceptions_by_code.note(0x02);
  device.quarantine = 1500ms;
  device.least_quarantine = 250ms;
  device.times.device.note(3ms);
  report.devices.push_back(device);
  report.listeners.push_back({"plant", 2, {}});
  report.listeners.back().counters.requests = 40;
  report.listeners.back().counters.note_refused(false, 0x0A, bus::Instant{});
  return report;
}

std::string text_of(const gateway::StatusReport& report, bool by_client = false) {
  return metrics_text(metric_families(report, {"0.1.0", "plant.toml", {}, false}, by_client));
}

TEST(Metrics, HaveTheNamesOfTheConfiguration) {
  const std::string text = text_of(report());
  EXPECT_THAT(text, HasSubstr("mbgate_bus_open{bus=\"line-a\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_bus_busy_seconds_total{bus=\"line-a\"} 1.5\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_bus_losses_total{bus=\"line-a\"} 2\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_bus_refused_requests_total{bus=\"line-a\","
                              "reason=\"queue_full\"} 3\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_device_timeouts_total{bus=\"line-a\",device=\"feeder\","
                              "address=\"7\"} 5\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_device_quarantine_seconds{bus=\"line-a\",device=\"feeder\","
                              "address=\"7\"} 1.5\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_device_least_quarantine_seconds{bus=\"line-a\","
                              "device=\"feeder\",address=\"7\"} 0.25\n"));
  EXPECT_THAT(text, HasSubstr("address=\"7\",state=\"offline\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("address=\"7\",state=\"answering\"} 0\n"));
  EXPECT_THAT(text, HasSubstr("address=\"7\",code=\"02\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_listener_open_connections{listener=\"plant\"} 2\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_listener_requests_total{listener=\"plant\"} 40\n"));
  EXPECT_THAT(text, HasSubstr("kind=\"write\",code=\"0A\",reason=\"no_path\"} 1\n"));
}

TEST(Metrics, SayWhichLineABusHas) {
  EXPECT_THAT(text_of(report()),
              HasSubstr("mbgate_bus_info{bus=\"line-a\",line=\"/dev/ttyUSB0\",framing=\"rtu\","
                        "baud=\"19200\",format=\"8E1\"} 1\n"));
}

// Each bucket holds what is not longer, and the last one everything.
TEST(Metrics, CountInBuckets) {
  const std::string text = text_of(report());
  const std::string name = "mbgate_bus_silence_seconds_bucket{bus=\"line-a\",le=";
  EXPECT_THAT(text, HasSubstr(name + "\"0.002\"} 0\n"));
  EXPECT_THAT(text, HasSubstr(name + "\"0.0025\"} 1\n"));
  EXPECT_THAT(text, HasSubstr(name + "\"+Inf\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_bus_silence_seconds_sum{bus=\"line-a\"} 0.002005\n"));
  EXPECT_THAT(text, HasSubstr("address=\"7\",part=\"device\",le=\"0.005\"} 1\n"));
}

TEST(Metrics, CountAddressesWithoutADeviceTogether) {
  gateway::StatusReport plant = report();
  gateway::DeviceStatus unnamed;
  unnamed.address = 40;
  unnamed.counters.timeouts = 2;
  unnamed.counters.wire_time = 250ms;
  unnamed.times.queue.note(1ms);
  plant.devices.push_back(unnamed);
  unnamed.address = 41;
  plant.devices.push_back(unnamed);
  const std::string text = text_of(plant);
  const std::string labels = R"({bus="line-a",device="other",address="")";
  EXPECT_THAT(text, HasSubstr("mbgate_device_timeouts_total" + labels + "} 4\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_device_wire_seconds_total" + labels + "} 0.5\n"));
  EXPECT_THAT(text,
              HasSubstr("mbgate_device_latency_seconds_count" + labels + ",part=\"queue\"} 2\n"));
  EXPECT_THAT(text, Not(HasSubstr("mbgate_device_state" + labels)));
}

TEST(Metrics, NameClientsOnlyIfAsked) {
  gateway::StatusReport plant = report();
  plant.clients.push_back({"10.0.0.7", "plant", 5, 1, 0});
  plant.clients.push_back({"10.0.0.7", "plant", 6, 0, 0});
  EXPECT_THAT(text_of(plant), Not(HasSubstr("10.0.0.7")));
  EXPECT_THAT(text_of(plant, true),
              HasSubstr("mbgate_client_requests{listener=\"plant\",client=\"10.0.0.7\"} 11\n"));
}

TEST(Metrics, SayThatAReloadWasRefused) {
  ProcessStatus process{"0.1.0", "plant.toml", {}, false};
  const std::string name = "mbgate_config_last_reload_successful ";
  EXPECT_THAT(metrics_text(metric_families(report(), process, false)), HasSubstr(name + "1\n"));
  process.reload_refused = true;
  EXPECT_THAT(metrics_text(metric_families(report(), process, false)), HasSubstr(name + "0\n"));
}

TEST(Metrics, SayWhenCertificatesEnd) {
  using std::chrono::system_clock;
  ProcessStatus process{"0.1.0", "plant.toml", {}, false};
  process.certificates = {
      {"plant", system_clock::from_time_t(1'800'000'000), {}},
      {"cell", system_clock::from_time_t(1'900'000'000), system_clock::from_time_t(1'700'000'000)}};
  const std::string text = metrics_text(metric_families(report(), process, false));
  EXPECT_THAT(text,
              HasSubstr("mbgate_certificate_expiry_timestamp_seconds{tls=\"plant\"} 1800000000\n"));
  EXPECT_THAT(text,
              HasSubstr("mbgate_certificate_expiry_timestamp_seconds{tls=\"cell\"} 1900000000\n"));
  EXPECT_THAT(text, HasSubstr("mbgate_crl_expiry_timestamp_seconds{tls=\"cell\"} 1700000000\n"));
}

TEST(Metrics, CountFailuresOfTlsByListener) {
  ProcessStatus process{"0.1.0", "plant.toml", {}, false};
  const std::string name = "mbgate_listener_tls_failures_total{listener=\"plant\"} ";
  EXPECT_THAT(metrics_text(metric_families(report(), process, false)), HasSubstr(name + "0\n"));
  process.tls_failures = {{"plant", 7}, {"gone", 3}};
  const std::string text = metrics_text(metric_families(report(), process, false));
  EXPECT_THAT(text, HasSubstr(name + "7\n"));
  EXPECT_THAT(text, Not(HasSubstr("gone")));
}

TEST(Metrics, ShowTheProcess) {
  const std::string text = metrics_text(process_families());
  for (const char* name : {"process_cpu_seconds_total ", "process_open_fds ", "process_max_fds ",
                           "process_resident_memory_bytes ", "process_start_time_seconds "}) {
    EXPECT_THAT(text, HasSubstr(std::string("\n") + name));
  }
}

// changes(process_start_time_seconds[15m]) > 0 says that it was started again.
TEST(Metrics, ShowTheSameStartOfTheProcessEachTime) {
  const auto started = [] {
    const std::string text = metrics_text(process_families());
    const std::string name = "\nprocess_start_time_seconds ";
    const std::size_t begin = text.find(name) + name.size();
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  const std::string first = started();
  EXPECT_GT(std::stod(first), 1e9);
  for (int at = 0; at < 50; ++at) {
    EXPECT_EQ(started(), first);
  }
}

}  // namespace
}  // namespace mbgate::app
