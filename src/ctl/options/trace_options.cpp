// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/trace_options.hpp"

#include <arpa/inet.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>

#include "ctl/options/control_options.hpp"
#include "modbus/function_code.hpp"

namespace mbgate::ctl {
namespace {

constexpr unsigned kMostRecords = 1'000'000'000;

/// "16" or "0x10".
std::optional<std::uint8_t> function_code(std::string_view text) {
  const bool is_hex = text.starts_with("0x") || text.starts_with("0X");
  text.remove_prefix(is_hex ? 2 : 0);
  std::uint8_t code = 0;
  const char* const end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, code, is_hex ? 16 : 10);
  const bool is_code =
      parsed.ec == std::errc() && parsed.ptr == end && modbus::is_request_function(code);
  return is_code ? std::optional(code) : std::nullopt;
}

bool is_ip_address(const std::string& text) {
  std::array<unsigned char, sizeof(in6_addr)> octets{};
  return ::inet_pton(AF_INET, text.c_str(), octets.data()) == 1 ||
         ::inet_pton(AF_INET6, text.c_str(), octets.data()) == 1;
}

}  // namespace

TraceOptions::TraceOptions(CLI::App& app)
    : trace_(app.add_subcommand(
          "trace",
          "Print what goes through a running mbgated: each request as it came, what went on the "
          "wire for it, what was heard, what the client got.")) {
  TraceFilter& filter = words_.filter;
  trace_->add_option("--bus", filter.bus, "only what goes over this bus")->type_name("NAME");
  trace_->add_option("--device", filter.device, "only what concerns this device")
      ->type_name("NAME");
  trace_->add_option("--client", filter.client, "only requests of this client, by its IP address")
      ->type_name("ADDRESS");
  trace_->add_option("--function", function_, "only requests with this function code")
      ->type_name("N");
  trace_->add_flag("--failed", filter.only_failed, "only what failed");
  trace_->add_flag("--json", words_.json, "for programs: one JSON object a line");
  auto* pcapng = trace_
                     ->add_option("--pcapng", words_.pcapng,
                                  "write a capture for Wireshark too; - is standard output")
                     ->type_name("FILE");
  trace_->add_flag("--quiet", words_.quiet, "with --pcapng: print nothing")->needs(pcapng);
  trace_->add_option("--times", words_.times, "end after so many records")
      ->check(CLI::Range(1U, kMostRecords));
  add_control(*trace_, words_.socket);
}

bool TraceOptions::given() const { return trace_->parsed(); }

Result<Command, std::string> TraceOptions::command() const {
  TraceCommand trace = words_;
  if (!trace.filter.client.empty() && !is_ip_address(trace.filter.client)) {
    return "--client \"" + trace.filter.client +
           "\" is not an IP address, like 192.168.10.5 or fd00::5";
  }
  if (!function_.empty()) {
    trace.filter.function = function_code(function_);
    if (!trace.filter.function) {
      return "--function \"" + function_ + "\" is not a function code: 1 to 127, like 3 or 0x10";
    }
  }
  if (trace.pcapng == "-" && trace.json) {
    return std::string("--json and --pcapng - both want standard output: name a file for one");
  }
  return Command(trace);
}

}  // namespace mbgate::ctl
