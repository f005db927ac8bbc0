// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/trace_query.hpp"

#include <cstdio>
#include <string_view>

namespace mbgate::ctl {
namespace {

constexpr std::string_view kUnreserved =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";

std::string percent_encoded(std::string_view text) {
  std::string encoded;
  for (const char character : text) {
    if (kUnreserved.find(character) != std::string_view::npos) {
      encoded += character;
    } else {
      char octet[sizeof "%C3"];
      std::snprintf(octet, sizeof octet, "%%%02X", unsigned{static_cast<unsigned char>(character)});
      encoded += octet;
    }
  }
  return encoded;
}

}  // namespace

std::string trace_target(const TraceFilter& filter) {
  std::string query;
  const auto add = [&](std::string_view key, std::string_view value) {
    if (!value.empty()) {
      query.append(query.empty() ? "?" : "&")
          .append(key)
          .append("=")
          .append(percent_encoded(value));
    }
  };
  add("bus", filter.bus);
  add("device", filter.device);
  add("client", filter.client);
  add("function", filter.function ? std::to_string(*filter.function) : "");
  add("only", filter.only_failed ? "failed" : "");
  return "/api/v1/trace" + query;
}

}  // namespace mbgate::ctl
