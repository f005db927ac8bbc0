// SPDX-License-Identifier: Apache-2.0
#include "app/trace/trace_filter.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <system_error>
#include <utility>

#include "base/text.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::app {
namespace {

/// "a%20b+c" is "a b c" (application/x-www-form-urlencoded); nothing if a '%' has no two digits.
std::optional<std::string> decoded(std::string_view text) {
  std::string plain;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] != '%') {
      plain += text[at] == '+' ? ' ' : text[at];
      continue;
    }
    constexpr std::size_t kDigits = 2;
    const std::string_view digits = text.substr(at + 1, kDigits);
    const auto byte = integer_in<unsigned char>(digits, 16);
    if (!byte || digits.size() != kDigits) {
      return std::nullopt;
    }
    plain += static_cast<char>(*byte);
    at += kDigits;
  }
  return plain;
}

/// Takes what stands before the separator, or all, out of the text.
std::string_view take_before(std::string_view& text, char separator) {
  const std::string_view part = text.substr(0, text.find(separator));
  text.remove_prefix(std::min(part.size() + 1, text.size()));
  return part;
}

/// Returns what is wrong, or nothing.
std::string set(TraceFilter& filter, std::string_view key, const std::string& value) {
  if (key == "bus") {
    filter.bus = value;
  } else if (key == "device") {
    filter.device = value;
  } else if (key == "client") {
    filter.client = routing::ClientAddress::parse(value);
    return filter.client ? "" : fmt::format("client={}: expected an IP address", value);
  } else if (key == "function") {
    filter.function = integer_in<std::uint8_t>(value);
    return filter.function ? "" : fmt::format("function={}: expected a number, 0 to 255", value);
  } else if (key == "only" && value == "failed") {
    filter.only_failed = true;
  } else if (key == "events" && value == "1") {
    filter.with_journal = true;
  } else {
    return fmt::format("{}={}: expected bus=, device=, client=, function=, only=failed or events=1",
                       key, value);
  }
  return {};
}

}  // namespace

Result<TraceFilter, std::string> TraceFilter::parse(std::string_view query) {
  TraceFilter filter;
  while (!query.empty()) {
    std::string_view value = take_before(query, '&');
    const std::string_view key = take_before(value, '=');
    const auto plain = decoded(value);
    std::string wrong = plain ? set(filter, key, *plain)
                              : fmt::format("{}: expected two hexadecimal digits after %", key);
    if (!wrong.empty()) {
      return {boost::system::in_place_error, std::move(wrong)};
    }
  }
  return filter;
}

bool TraceFilter::matches(const gateway::TraceRecord& record) const {
  if (only_failed && !record.is_failed()) {
    return false;
  }
  if (client && (!record.asked || record.asked->client != *client)) {
    return false;
  }
  if (function && (!record.asked || record.asked->request[modbus::kMbapHeaderSize] != *function)) {
    return false;
  }
  const auto is_one = [](const auto& all, const auto& name, auto member) {
    return std::ranges::find(all, name, member) != all.end();
  };
  using Target = gateway::AskedTrace::Target;
  const auto is_of = [&](const auto& name, auto of_wire, auto of_target) {
    return !name || is_one(record.wire, *name, of_wire) ||
           (record.asked && is_one(record.asked->targets, *name, of_target));
  };
  return is_of(bus, &gateway::WireTrace::bus, &Target::bus) &&
         is_of(device, &gateway::WireTrace::device, &Target::device);
}

}  // namespace mbgate::app
