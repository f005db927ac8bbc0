// SPDX-License-Identifier: Apache-2.0
#include "config/keys/keys.hpp"

#include <array>
#include <fmt/core.h>
#include <limits>

#include "config/toml/toml_value.hpp"

namespace mbgate::config {
namespace {

using namespace std::chrono_literals;
using bus::BusSettings;
using bus::ConnectionTimes;
using bus::LineSettings;
using drive::Device;
using drive::DeviceTiming;
using gateway::DeviceGuard;
using gateway::HandshakeSettings;
using gateway::HttpSettings;
using gateway::ListenerSettings;
using gateway::Settings;
using gateway::TcpSettings;

constexpr std::string_view kSerial =
    "belongs to a serial line; a Modbus TCP server has 'host' and 'port'";
constexpr std::string_view kRtu = R"(belongs to mode = "rtu": ASCII characters may be 1s apart)";
constexpr std::string_view kPort = "belongs to a serial port of this machine";
constexpr std::string_view kServer = R"(belongs to mode = "tcp")";
constexpr std::string_view kConnection =
    R"(belongs to a TCP connection: mode = "tcp", or device = "tcp://host:port")";
constexpr std::string_view kSilence = "belongs to serial lines: a connection needs no silence";

constexpr std::int64_t kFastest = std::numeric_limits<std::uint32_t>::max();
/// A server takes 1 to 16 transactions at a time (Messaging on TCP/IP V1.0b, 4.3.2,
/// NumberMaxOfServerTransaction): more would only wait there instead of here.
constexpr IntegerRange kOutstanding = {1, 16};
/// The longest that Linux takes (serial_core.c, RS485_MAX_RTS_DELAY).
constexpr DurationRange kRtsDelay = {.min = 0s, .max = 100ms, .step = 1ms};
/// What Linux takes for TCP_KEEPIDLE and TCP_KEEPINTVL (tcp.h, MAX_TCP_KEEPIDLE), and for
/// TCP_KEEPCNT.
constexpr std::chrono::seconds kLongestKeepalive = 32767s;
constexpr IntegerRange kKeepaliveProbes = {1, 127};

constexpr std::array kGatewayKeys = {
    plain<&Settings::lock_memory>("lock_memory", Truth{}),
    plain<&Settings::audit>("audit", Truth{}),
    plain<&Settings::wake_early>("wake_early", DurationRange{0us, 1ms}),
};

constexpr std::array kHttpKeys = {
    plain<&HttpSettings::max_streams>("max_streams", IntegerRange{1, 100'000}),
    plain<&HttpSettings::client_metrics>("client_metrics", Truth{}),
};

constexpr std::array kListenerKeys = {
    plain<&ListenerSettings::freebind>("freebind", Truth{}),
    plain<&ListenerSettings::max_connections>("max_connections", IntegerRange{1, 100'000}),
    plain<&ListenerSettings::max_connections_per_address>("max_connections_per_address",
                                                          IntegerRange{1, 100'000}),
    plain<&ListenerSettings::max_connects_per_second>("max_connects_per_second",
                                                      IntegerRange{0, 1'000'000}),
    plain<&ListenerSettings::max_requests_per_second>("max_requests_per_second",
                                                      IntegerRange{0, 1'000'000}),
    plain<&ListenerSettings::pipeline>("pipeline", IntegerRange{1, 64}),
    plain<&ListenerSettings::ordered>("ordered", Truth{}),
    plain<&ListenerSettings::give_up>("give_up", DurationRange{10ms, 1h, true}),
    plain<&ListenerSettings::one_at_a_time>("one_at_a_time", Truth{}),
    plain<&ListenerSettings::idle_timeout>("idle_timeout", DurationRange{10ms, 1000h, true}),
    plain<&ListenerSettings::frame_timeout>("frame_timeout", DurationRange{10ms, 1h}),
    plain<&ListenerSettings::tcp, &TcpSettings::keepalive_idle>(
        "keepalive_idle", DurationRange{1s, kLongestKeepalive, true, 1s}),
    plain<&ListenerSettings::tcp, &TcpSettings::keepalive_interval>(
        "keepalive_interval", DurationRange{1s, kLongestKeepalive, false, 1s}),
    plain<&ListenerSettings::tcp, &TcpSettings::keepalive_probes>("keepalive_probes",
                                                                  kKeepaliveProbes),
    plain<&ListenerSettings::tcp, &TcpSettings::user_timeout>("user_timeout",
                                                              DurationRange{100ms, 24h, true}),
    plain<&ListenerSettings::tcp, &TcpSettings::backlog>("backlog", IntegerRange{1, 65535}),
    plain<&ListenerSettings::broadcast>("broadcast", Truth{}),
    plain<&ListenerSettings::handshakes, &HandshakeSettings::timeout>("handshake_timeout",
                                                                      DurationRange{100ms, 10min}),
    plain<&ListenerSettings::handshakes, &HandshakeSettings::hello>("hello_timeout",
                                                                    DurationRange{100ms, 10min}),
    plain<&ListenerSettings::handshakes, &HandshakeSettings::at_a_time>("max_handshakes",
                                                                        IntegerRange{1, 100'000}),
    plain<&ListenerSettings::handshakes, &HandshakeSettings::for_one_client>(
        "max_handshakes_per_client", IntegerRange{1, 100'000}),
    plain<&ListenerSettings::handshakes, &HandshakeSettings::per_second>(
        "max_handshakes_per_second", IntegerRange{0, 100'000}),
    plain<&ListenerSettings::handshakes, &HandshakeSettings::per_second_for_one_client>(
        "max_handshakes_per_second_per_client", IntegerRange{0, 100'000}),
};

constexpr std::array kBusKeys = {
    plain<&BusSettings::line, &LineSettings::baud>("baud", IntegerRange{1, kFastest}, Lines::serial,
                                                   kSerial),
    plain<&BusSettings::line, &LineSettings::format, &modbus::CharacterFormat::stop_bits>(
        "stop_bits", IntegerRange{1, 2}, Lines::serial, kSerial),
    plain<&BusSettings::line, &LineSettings::rs485_rts_on_send>("rs485_rts_on_send", Truth{},
                                                                Lines::serial, kSerial),
    plain<&BusSettings::line, &LineSettings::rs485_delay_before>("rs485_delay_before", kRtsDelay,
                                                                 Lines::serial, kSerial),
    plain<&BusSettings::line, &LineSettings::rs485_delay_after>("rs485_delay_after", kRtsDelay,
                                                                Lines::serial, kSerial),
    plain<&BusSettings::line, &LineSettings::low_latency>("low_latency", Truth{}, Lines::ports,
                                                          kPort),
    plain<&BusSettings::turnaround>("turnaround", DurationRange{0s, 1min}, Lines::serial, kSerial),
    plain<&BusSettings::frame_gap>("frame_gap", DurationRange{0s, 1s}, Lines::serial, kSerial),
    plain<&BusSettings::frame_slack>("frame_slack", DurationRange{1ms, 10s}, Lines::rtu, kRtu),
    plain<&BusSettings::listen_first>("listen_first", DurationRange{0s, 1min}, Lines::serial,
                                      kSerial),
    plain<&BusSettings::settle>("settle", DurationRange{0s, 1min}, Lines::serial, kSerial),
    plain<&BusSettings::queue>("queue", IntegerRange{1, 1'000'000}),
    plain<&BusSettings::burst>("burst", IntegerRange{1, 1000}),
    plain<&BusSettings::stop_wait>("stop_wait", DurationRange{0s, 10s}),
    plain<&BusSettings::stop_deadline>("stop_deadline", DurationRange{1ms, 1min}, Lines::serial,
                                       kSilence),
    plain<&BusSettings::probe_share>("probe_share", IntegerRange{1, 100}),
    plain<&BusSettings::coalesce>("coalesce", Truth{}),
    plain<&BusSettings::reopen_min>("reopen_min", DurationRange{10ms, 1h}),
    plain<&BusSettings::reopen_max>("reopen_max", DurationRange{10ms, 1h}),
    plain<&BusSettings::hung_after>("hung_after", DurationRange{1s, 24h, true}, Lines::serial,
                                    kSerial),
    plain<&BusSettings::hung_max>("hung_max", DurationRange{1s, 24h}, Lines::serial, kSerial),
    plain<&BusSettings::hung_requests>("hung_requests", IntegerRange{1, 1'000'000}, Lines::serial,
                                       kSerial),
    plain<&BusSettings::one_device>(
        "one_device", Truth{}, Lines::server,
        R"(belongs to mode = "tcp": on a serial line each device has its address)"),
    plain<&BusSettings::outstanding>(
        "outstanding", kOutstanding,
        Lines::server, R"(belongs to mode = "tcp": a serial line carries one request at a time)"),
    plain<&BusSettings::check_unit>("check_unit", Truth{}, Lines::server, kServer),
    plain<&BusSettings::check_transaction>("check_transaction", Truth{}, Lines::server, kServer),
    plain<&BusSettings::connect_delay>("connect_delay", DurationRange{0s, 1min}, Lines::server,
                                       kServer),
    plain<&BusSettings::replace_after>("replace_after", IntegerRange{0, 1000}, Lines::server,
                                       kServer),
    plain<&BusSettings::line, &LineSettings::connection, &ConnectionTimes::connect_timeout>(
        "connect_timeout", DurationRange{100ms, 1min}, Lines::connections, kConnection),
    plain<&BusSettings::line, &LineSettings::connection, &ConnectionTimes::acknowledge_timeout>(
        "acknowledge_timeout", DurationRange{100ms, 1min}, Lines::connections, kConnection),
    plain<&BusSettings::line, &LineSettings::connection, &ConnectionTimes::idle_probe>(
        "idle_probe", DurationRange{2s, 1h, false, 1s}, Lines::connections, kConnection),
};

constexpr std::array kTimingKeys = {
    plain<&DeviceTiming::response_timeout>("response_timeout", DurationRange{1ms, 1h}),
    plain<&DeviceTiming::retries>("retries", IntegerRange{0, 100}),
    plain<&DeviceTiming::stop_retries>("stop_retries", IntegerRange{0, 100}),
    plain<&DeviceTiming::quarantine>("quarantine", DurationRange{0s, 1h}),
    plain<&DeviceTiming::quarantine_max>("quarantine_max", DurationRange{0s, 1h}),
    plain<&DeviceTiming::offline_after>("offline_after", IntegerRange{0, 1000}),
    plain<&DeviceTiming::probe_interval>("probe_interval", DurationRange{1ms, 1h}),
    plain<&DeviceTiming::probe_timeout>("probe_timeout", DurationRange{1ms, 1h}),
};

constexpr std::array kDeviceKeys = {
    plain<&Device::timing, &DeviceTiming::response_wait>("response_wait", DurationRange{0s, 1min}),
    plain<&Device::timing, &DeviceTiming::gap>("gap", DurationRange{0s, 1min}),
    plain<&Device::timing, &DeviceTiming::gap_after_write>("gap_after_write",
                                                           DurationRange{0s, 1min}),
    plain<&Device::timing, &DeviceTiming::retry_writes>("retry_writes", Truth{}),
    plain<&Device::cache>("cache", DurationRange{0s, 1h}),
    plain<&Device::verify_word_order>("verify_word_order", Truth{}),
    plain<&Device::split_values>("split_values", Truth{}),
    plain<&Device::split_writes>("split_writes", Truth{}),
    plain<&Device::allow_reconfigure>("allow_reconfigure", Truth{}),
};

constexpr std::array kGuardKeys = {
    plain<&DeviceGuard::writer_hold>("writer_hold", DurationRange{1ms, 1h}),
    plain<&DeviceGuard::quiet>("quiet", DurationRange{10ms, 24h, true}),
    plain<&DeviceGuard::failsafe_grace>("failsafe_grace", DurationRange{0s, 1h}),
    plain<&DeviceGuard::failsafe_on_exit>("failsafe_on_exit", Truth{}),
};

struct RangeToText {
  std::string operator()(Truth /*none*/) const { return "true or false"; }
  std::string operator()(const auto& range) const { return range_text(range); }
};

struct ToText {
  std::string operator()(std::monostate /*none*/) const { return "-"; }
  std::string operator()(bool truth) const { return truth ? "true" : "false"; }
  std::string operator()(std::int64_t number) const { return std::to_string(number); }
  std::string operator()(std::chrono::nanoseconds duration) const {
    return in_quotes(to_text(duration));
  }
};

std::string_view place_of(Lines lines) {
  switch (lines) {
    case Lines::any: return "everywhere";
    case Lines::serial: return "serial lines";
    case Lines::ports: return "serial ports of this machine";
    case Lines::rtu: return "mode = \"rtu\"";
    case Lines::connections: return "TCP connections";
    case Lines::server: return "mode = \"tcp\"";
    case Lines::port_rtu:
    case Lines::port_ascii:
    case Lines::remote_rtu:
    case Lines::remote_ascii: break;
  }
  return {};
}

template <typename Section>
void list(std::string& text, std::string_view title, std::span<const PlainKey<Section>> keys,
          const std::type_identity_t<Section>& defaults) {
  for (const auto& key : keys) {
    text +=
        fmt::format("{}\t{}\t{}\t{}\t{}\n", title, key.name, std::visit(RangeToText(), key.range),
                    value_text(key.get(defaults)), place_of(key.lines));
  }
}

}  // namespace

std::span<const PlainKey<Settings>> gateway_keys() { return kGatewayKeys; }
std::span<const PlainKey<HttpSettings>> http_keys() { return kHttpKeys; }
std::span<const PlainKey<ListenerSettings>> listener_keys() { return kListenerKeys; }
std::span<const PlainKey<BusSettings>> bus_keys() { return kBusKeys; }
std::span<const PlainKey<DeviceTiming>> timing_keys() { return kTimingKeys; }
std::span<const PlainKey<Device>> device_keys() { return kDeviceKeys; }
std::span<const PlainKey<DeviceGuard>> guard_keys() { return kGuardKeys; }

Lines lines_of(const LineSettings& line) {
  switch (line.framing) {
    case bus::Framing::tcp: return Lines::server;
    case bus::Framing::rtu: return line.remote ? Lines::remote_rtu : Lines::port_rtu;
    case bus::Framing::ascii: return line.remote ? Lines::remote_ascii : Lines::port_ascii;
  }
  return Lines::any;
}

std::string value_text(const KeyValue& value) { return std::visit(ToText(), value); }

std::string list_keys() {
  std::string text;
  list(text, "[gateway]", gateway_keys(), {});
  list(text, "[http]", http_keys(), {});
  list(text, "[[listen]]", listener_keys(), {});
  list(text, "[[bus]]", bus_keys(), {});
  list(text, "[[bus]]", timing_keys(), {});
  list(text, "[[device]]", timing_keys(), {});
  list(text, "[[device]]", device_keys(), {});
  list(text, "[[device]]", guard_keys(), {});
  return text;
}

KeyValue read_key(TomlTable& table, std::string_view key, const KeyRange& range) {
  const auto or_nothing = [](const auto& value) { return value ? KeyValue(*value) : KeyValue(); };
  if (const auto* integers = std::get_if<IntegerRange>(&range)) {
    return or_nothing(table.integer(key, *integers));
  }
  if (const auto* durations = std::get_if<DurationRange>(&range)) {
    return or_nothing(table.duration(key, *durations));
  }
  return or_nothing(table.boolean(key));
}

}  // namespace mbgate::config
