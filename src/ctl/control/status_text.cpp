// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/status_text.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <boost/json/value_to.hpp>
#include <chrono>
#include <cmath>
#include <fmt/core.h>
#include <tuple>

#include "base/text.hpp"
#include "ctl/visible_text.hpp"
#include "modbus/codes.hpp"

namespace mbgate::ctl {
namespace {

using boost::json::object;
using boost::json::value;
using Row = std::vector<std::string>;
using Seconds = std::chrono::duration<double>;

std::string text(const object& from, const char* key) {
  const value& found = from.at(key);
  return found.is_null() ? "-" : visible_text(found.as_string());
}

double number(const object& from, const char* key) { return from.at(key).to_number<double>(); }

std::string whole(const object& from, const char* key) {
  return from.at(key).is_null() ? "-" : std::to_string(std::llround(number(from, key)));
}

// "0.4", "12", "1300": three digits are enough to see which drive is slow.
std::string milliseconds(const value& duration) {
  if (duration.is_null()) {
    return "-";
  }
  const auto number = duration.to_number<double>();
  constexpr double kShort = 10;
  return number < kShort ? fmt::format("{:.1f}", number) : fmt::format("{:.0f}", number);
}

std::string diagnoses_text(const boost::json::array& diagnoses) {
  if (diagnoses.empty()) {
    return "No faults found.\n";
  }
  std::string all = "FAULTS\n";
  for (const value& one : diagnoses) {
    const object& diagnosis = one.as_object();
    all += fmt::format("  {}: {}\n", text(diagnosis, "subject"), text(diagnosis, "finding"));
    all += fmt::format("      because: {}\n", text(diagnosis, "evidence"));
    all += fmt::format("      look at: {}\n", text(diagnosis, "look_at"));
  }
  return all;
}

std::string buses_text(const boost::json::array& buses) {
  if (buses.empty()) {
    return "no [[bus]] is configured\n";
  }
  std::vector<Row> rows{{"BUS", "LINE", "MODE", "STATE", "LOAD", "WAITING", "ANSWERS", "TIMEOUTS",
                         "BAD CRC", "LATE"}};
  for (const value& one : buses) {
    const object& bus = one.as_object();
    const object& counters = bus.at("counters").as_object();
    rows.push_back(
        {text(bus, "name"), text(bus, "line"),
         bus.at("baud").is_null() ? text(bus, "discipline")
                                  : fmt::format("{} {}", whole(bus, "baud"), text(bus, "format")),
         bus.at("open").as_bool() ? "open" : "not open", whole(bus, "load_percent") + " %",
         whole(bus, "waiting"), whole(counters, "responses"), whole(counters, "timeouts"),
         whole(counters, "bad_crcs"), whole(counters, "late_responses")});
  }
  return columns(rows, {.indent = "", .words = 4});
}

// Those that do not answer first, then those whose answers are bad, then the slow ones.
bool is_worse(const value& a, const value& b) {
  const auto rank = [](const value& one) {
    const object& device = one.as_object();
    const std::string state = text(device, "state");
    const std::string quality = text(device.at("quality").as_object(), "verdict");
    const value& slow = device.at("latency_ms").as_object().at("device").as_object().at("p90");
    return std::tuple(
        state != "answering" && state != "not asked", number(device, "unanswered_in_row"),
        quality != "good" && quality != "unknown", slow.is_null() ? 0.0 : slow.to_number<double>());
  };
  return rank(a) > rank(b);
}

// "02 (illegal data address): 3, other codes: 1"
std::string exceptions_text(const object& exceptions) {
  std::string all;
  for (const auto& [code, count] : exceptions) {
    all += all.empty() ? "    exceptions: " : ", ";
    if (code == "other") {
      all += "other codes";
    } else {
      constexpr int kHexadecimal = 16;
      const auto name = modbus::exception_name(
          static_cast<std::uint8_t>(std::stoul(std::string(code), nullptr, kHexadecimal)));
      all += visible_text(code) + (name.empty() ? "" : fmt::format(" ({})", name));
    }
    all += fmt::format(": {}", count.to_number<std::uint64_t>());
  }
  return all.empty() ? all : all + "\n";
}

// "answering", "offline for 4 min": how long a device has been answering does not matter.
std::string state_text(const object& device) {
  const std::string state = text(device, "state");
  const value& since = device.at("state_since_s");
  return state == "answering" || since.is_null()
             ? state
             : fmt::format("{} for {}", state, passed_text(Seconds(since.to_number<double>())));
}

std::string devices_text(boost::json::array devices) {
  std::ranges::stable_sort(devices, is_worse);
  std::vector<Row> rows{{"DEVICE", "BUS", "ADDRESS", "STATE", "ANSWERS", "TIMEOUTS", "BAD CRC",
                         "LATE", "QUEUE", "WIRE", "DRIVE", "P90", "P99"}};
  std::vector<std::string> details(1);
  for (const value& one : devices) {
    const object& device = one.as_object();
    const object& counters = device.at("counters").as_object();
    const object& latency = device.at("latency_ms").as_object();
    const auto half = [&](const char* part) {
      return milliseconds(latency.at(part).as_object().at("p50"));
    };
    const object& own = latency.at("device").as_object();
    rows.push_back({text(device, "name"), text(device, "bus"), whole(device, "address"),
                    state_text(device), whole(counters, "responses"), whole(counters, "timeouts"),
                    whole(counters, "bad_crcs"), whole(counters, "late_responses"), half("queue"),
                    half("wire"), half("device"), milliseconds(own.at("p90")),
                    milliseconds(own.at("p99"))});
    details.push_back(exceptions_text(device.at("exceptions").as_object()));
  }
  return columns(rows, {.indent = "", .words = 4, .below = details});
}

std::string clients_text(const boost::json::array& clients) {
  std::vector<Row> rows{{"CLIENT", "LISTENER", "REQUESTS", "OUTSTANDING", "REFUSED"}};
  for (const value& one : clients) {
    const object& client = one.as_object();
    rows.push_back({text(client, "address"), text(client, "listener"), whole(client, "requests"),
                    whole(client, "outstanding"), whole(client, "refused")});
  }
  return columns(rows, {.indent = "", .words = 2});
}

bool is_first_byte(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;  // UTF-8, RFC 3629
}

bool moves_cursor(char byte) { return static_cast<unsigned char>(byte) < 0x20U || byte == '\x7F'; }

/// How many bytes the first `columns` characters have.
std::size_t bytes_of(std::string_view line, std::size_t columns) {
  std::size_t at = 0;
  for (std::size_t characters = 0; at < line.size(); ++at) {
    if (is_first_byte(line[at]) && ++characters > columns) {
      break;
    }
  }
  return at;
}

std::size_t indent_of(std::string_view line) {
  return std::min(line.find_first_not_of(' '), line.size());
}

bool is_row_of_table(std::string_view line) {
  return line.find("  ", indent_of(line)) != std::string_view::npos;
}

/// Ends lines at a blank; a word that is longer than a line is cut in two.
void fold(std::string line, std::size_t columns, std::vector<std::string>& lines) {
  constexpr std::size_t kFurther = 2;
  const std::size_t further = indent_of(line) + kFurther;
  const std::string indent(further < columns / 2 ? further : 0, ' ');
  while (true) {
    const std::size_t fits = bytes_of(line, columns);
    if (fits == line.size()) {
      lines.push_back(line);
      return;
    }
    const std::size_t blank = line.rfind(' ', fits);
    const bool is_after_word = blank != std::string::npos && blank > indent_of(line);
    const std::size_t end = is_after_word ? blank : fits;
    lines.push_back(line.substr(0, end));
    line.replace(0, is_after_word ? end + 1 : end, indent);
  }
}

}  // namespace

std::string status_text(const object& status) {
  const object& configuration = status.at("configuration").as_object();
  std::string all = fmt::format(
      "mbgated {}, up {}, {} as of {}, {}\n", text(status, "version"),
      passed_text(Seconds(number(status, "uptime_s"))), text(configuration, "file"),
      text(configuration, "read_at"),
      counted(static_cast<std::uint64_t>(std::llround(number(status, "requests"))), "request"));
  if (configuration.contains("sha256")) {  // not of an mbgated of before an upgrade
    all += fmt::format("Configuration: sha256 {}\n", text(configuration, "sha256"));
  }
  if (configuration.at("reload_refused").as_bool()) {
    all += "The last reload was refused: the settings in force are older than the file.\n";
  }
  all += "\n" + diagnoses_text(status.at("diagnoses").as_array());
  all += "\n" + buses_text(status.at("buses").as_array());
  const boost::json::array& devices = status.at("devices").as_array();
  if (!devices.empty()) {
    all += fmt::format(
        "\n{}QUEUE, WIRE, DRIVE: median times in ms of answered requests; P90, P99: percentiles of "
        "DRIVE\n",
        devices_text(devices));
  }
  const boost::json::array& clients = status.at("clients").as_array();
  if (!clients.empty()) {
    all += "\n" + clients_text(clients);
  }
  return all;
}

std::vector<std::string> page(std::string_view text, std::size_t rows, std::size_t columns) {
  std::vector<std::string> lines;
  if (rows == 0 || columns == 0) {
    return lines;
  }
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    std::ranges::replace_if(line, moves_cursor, '?');
    if (is_row_of_table(line)) {
      lines.push_back(line.substr(0, bytes_of(line, columns)));
    } else {
      fold(std::move(line), columns, lines);
    }
  }
  if (lines.size() > rows) {
    const std::size_t hidden = lines.size() - rows + 1;
    const std::string note =
        fmt::format("... {} more lines: the window is too small for them", hidden);
    lines.resize(rows);
    lines.back() = note.substr(0, columns);
  }
  return lines;
}

}  // namespace mbgate::ctl
