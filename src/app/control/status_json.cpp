// SPDX-License-Identifier: Apache-2.0
#include <boost/json/string.hpp>
#include <boost/json/value.hpp>
#include <fmt/core.h>
#include <optional>

#include "app/control/control_answers.hpp"
#include "app/text.hpp"
#include "config/toml/match_entry.hpp"
#include "report/findings/diagnosis.hpp"

namespace mbgate::app {
namespace {

using boost::json::object;
using boost::json::value;
using gateway::BusStatus;
using gateway::DeviceStatus;

double milliseconds(gateway::Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

value milliseconds(const std::optional<gateway::Duration>& duration) {
  return duration ? value(milliseconds(*duration)) : value(nullptr);
}

value seconds(const std::optional<gateway::Duration>& duration) {
  return duration ? value(std::chrono::duration<double>(*duration).count()) : value(nullptr);
}

const char* text_of(bus::LineState state) {
  switch (state) {
    case bus::LineState::initial: return "initial";
    case bus::LineState::idle: return "idle";
    case bus::LineState::emission: return "emission";
    case bus::LineState::waiting_for_reply: return "waiting for reply";
    case bus::LineState::waiting_turnaround_delay: return "waiting turnaround delay";
    case bus::LineState::draining: return "draining";
  }
  return "";
}

const char* text_of(DeviceStatus::State state) {
  switch (state) {
    case DeviceStatus::State::not_asked: return "not asked";
    case DeviceStatus::State::answering: return "answering";
    case DeviceStatus::State::not_answering: return "not answering";
    case DeviceStatus::State::offline: return "offline";
    case DeviceStatus::State::damaged: return "damaged answers";
    case DeviceStatus::State::line_not_open: return "line not open";
  }
  return "";
}

const char* text_of(bus::Quality quality) {
  switch (quality) {
    case bus::Quality::unknown: return "unknown";
    case bus::Quality::good: return "good";
    case bus::Quality::bad_crc: return "bad crc";
    case bus::Quality::no_frame: return "no valid frame";
    case bus::Quality::late: return "late";
  }
  return "";
}

object quality_json(const bus::QualityVerdict& verdict) {
  return {{"verdict", text_of(verdict.quality)}, {"count", verdict.count}, {"of", verdict.of}};
}

object counters_json(const bus::BusCounters& counters) {
  object json;
  for (const bus::CounterKind& counter : bus::kBusCounters) {
    json[counter.name] = counters.*counter.member;
  }
  return json;
}

object bus_json(const BusStatus& bus) {
  object json{{"name", bus.name},
              {"line", bus.line},
              {"discipline", config::word_for(config::kFramings, bus.framing)},
              {"baud", nullptr},
              {"format", nullptr},
              {"character_ms", nullptr},
              {"frame_gap_ms", nullptr},
              {"open", bus.is_open},
              {"state", text_of(bus.state)},
              {"load_percent", bus.load},
              {"waiting", bus.waiting},
              {"quality", quality_json(bus.quality)},
              {"counters", counters_json(bus.counters)}};
  if (bus.is_serial) {
    json["baud"] = static_cast<std::uint32_t>(bus.baud);
    json["format"] = modbus::format_text(bus.format);
  }
  if (bus.framing != bus::Framing::tcp) {
    json["character_ms"] = milliseconds(bus.character);
    json["frame_gap_ms"] = milliseconds(bus.frame_gap);
  }
  return json;
}

object percentiles_json(const bus::Latency& latency) {
  const bus::Durations& lately = latency.lately();
  return {{"p50", milliseconds(lately.percentile(50))},
          {"p90", milliseconds(lately.percentile(90))},
          {"p99", milliseconds(lately.percentile(99))}};
}

object exceptions_json(const bus::ExceptionCounts& exceptions) {
  object json;
  for (std::uint8_t code = 1; code <= bus::ExceptionCounts::kLastCode; ++code) {
    if (exceptions.of(code) > 0) {
      json[fmt::format("{:02X}", code)] = exceptions.of(code);
    }
  }
  if (exceptions.others() > 0) {
    json["other"] = exceptions.others();
  }
  return json;
}

object device_json(const DeviceStatus& device, const std::vector<BusStatus>& buses) {
  const bus::DeviceCounters& counters = device.counters;
  return {{"name", device.name.empty() ? value(nullptr) : value(boost::json::string(device.name))},
          {"bus", buses[device.bus].name},
          {"address", device.address},
          {"state", text_of(device.state)},
          {"state_since_s", seconds(device.state_since)},
          {"last_answer_ms_ago", milliseconds(device.last_answer)},
          {"unanswered_in_row", device.unanswered_in_row},
          {"held_back_ms", milliseconds(device.held_back)},
          {"quarantine_ms", milliseconds(device.quarantine)},
          {"next_probe_in_ms", milliseconds(device.next_probe)},
          {"response_timeout_ms", milliseconds(device.response_timeout)},
          {"quality", quality_json(device.quality)},
          {"latency_ms",
           {{"queue", percentiles_json(device.times.queue)},
            {"wire", percentiles_json(device.times.wire)},
            {"device", percentiles_json(device.times.device)}}},
          {"counters",
           {{"transmissions", counters.transmissions},
            {"responses", counters.responses},
            {"exceptions", counters.exceptions},
            {"timeouts", counters.timeouts},
            {"bad_crcs", counters.bad_crcs},
            {"late_responses", counters.late_responses},
            {"early_responses", counters.early_responses},
            {"noise_bytes", counters.noise_bytes}}},
          {"exceptions", exceptions_json(counters.exceptions_by_code)}};
}

object listener_json(const gateway::ListenerStatus& listener) {
  const auto& counters = listener.counters;
  object refused;
  for (std::size_t place = 0; place < gateway::kRefusalNames.size(); ++place) {
    refused[gateway::kRefusalNames.at(place)] = counters.refused_connections.at(place);
  }
  return {{"name", listener.name},
          {"connections", listener.connections},
          {"let_in", counters.connections},
          {"displaced",
           {{"max_connections", counters.displaced_full},
            {"max_connections_per_address", counters.displaced_address_full}}},
          {"refused", std::move(refused)}};
}

object client_json(const gateway::ClientStatus& client) {
  return {{"address", client.address},
          {"listener", client.listener},
          {"requests", client.requests},
          {"outstanding", client.outstanding},
          {"refused", client.refused}};
}

object diagnosis_json(const report::Diagnosis& diagnosis) {
  return {{"subject", diagnosis.subject},
          {"finding", diagnosis.finding},
          {"evidence", diagnosis.evidence},
          {"look_at", diagnosis.look_at}};
}

object certificate_json(const CertificateStatus& certificate) {
  object json{{"name", certificate.name}, {"ends", utc_second(certificate.ends) + "Z"}};
  if (certificate.crl_ends) {
    json["crl_ends"] = utc_second(*certificate.crl_ends) + "Z";
  }
  return json;
}

}  // namespace

object status_json(const gateway::StatusReport& report, const ProcessStatus& process) {
  return {{"version", process.version},
          {"uptime_s", std::chrono::duration<double>(report.uptime).count()},
          {"configuration",
           {{"file", valid_utf8(process.config)},
            {"read_at", utc_second(process.config_read_at) + "Z"},
            {"sha256", process.config_digest},
            {"reload_refused", process.reload_refused}}},
          {"certificates", array_of(process.certificates, certificate_json)},
          {"requests", report.counters.requests},
          {"foreign_adus", report.counters.foreign_adus},
          {"framing_lost", report.counters.framing_lost},
          {"diagnoses", array_of(report::diagnose(report), diagnosis_json)},
          {"buses", array_of(report.buses, bus_json)},
          {"devices",
           array_of(report.devices,
                    [&](const DeviceStatus& device) { return device_json(device, report.buses); })},
          {"listeners", array_of(report.listeners, listener_json)},
          {"clients", array_of(report.clients, client_json)}};
}

}  // namespace mbgate::app
