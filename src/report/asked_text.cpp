// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fmt/core.h>
#include <string_view>

#include "gateway/limits.hpp"
#include "modbus/describe.hpp"
#include "report/text.hpp"

namespace mbgate::report {
namespace {

using namespace gateway;
using modbus::Bytes;

/// What could write over other lines or colour a terminal is replaced: the name in a certificate is
/// written by whoever asked for the certificate.
std::string quoted(std::string_view name) {
  std::string text = "\"";
  for (std::size_t at = 0; at < std::min(name.size(), kToldName); ++at) {
    const auto byte = static_cast<unsigned char>(name[at]);
    const bool is_control = byte < 0x20 || byte == 0x7F || byte == '"';
    // U+0080 to U+009F are control characters too.
    const bool is_late_control = byte >= 0x80 && byte < 0xA0 && at > 0 && name[at - 1] == '\xC2';
    text += is_control || is_late_control ? '?' : name[at];
  }
  return text + (name.size() > kToldName ? "...\"" : "\"");
}

std::string range_text(const modbus::TableRange& range) {
  std::string_view name = modbus::table_name(range.table);
  name.remove_suffix(range.count == 1 ? 1 : 0);
  return fmt::format("{} {}", name, modbus::addresses_text(range));
}

std::string values_text(const modbus::Request& request, const modbus::TableRange& range) {
  // 22: the bits of the one stay, those of the other are set where they do not (6.16).
  if (const Bytes pdu = request.pdu().bytes(); pdu[0] == 0x16) {
    return fmt::format(" and {} or {}", modbus::load_be16(pdu, 3), modbus::load_be16(pdu, 5));
  }
  std::string text = " =";
  const auto told = std::min<std::size_t>(range.count, kToldValues);
  for (std::size_t at = 0; at < told; ++at) {
    const auto value = request.written(static_cast<std::uint16_t>(range.first + at)).value_or(0);
    const bool is_set_coil = range.table == modbus::Table::coils && value != 0;
    text += fmt::format(" {}", is_set_coil ? 1 : value);
  }
  return range.count > told ? fmt::format("{} and {} more", text, range.count - told) : text;
}

/// What stands behind the function of a request that names no registers.
std::string data_text(Bytes pdu) {
  if (pdu[0] == 0x08 && pdu.size() >= 3) {
    return fmt::format(", sub-function {}", modbus::load_be16(pdu, 1));
  }
  const Bytes data = pdu.subspan(1);
  const bool is_long = data.size() > kToldValues;
  return data.empty()
             ? std::string()
             : fmt::format(", data {}{}", modbus::hex(is_long ? data.first(kToldValues) : data),
                           is_long ? " ..." : "");
}

std::string registers_text(const modbus::Request& request) {
  std::string text;
  if (const auto& reads = request.reads()) {
    text += ", reads " + range_text(reads->range);
  }
  if (const auto& writes = request.writes()) {
    text += fmt::format("{}{}{}", request.reads() ? ", writes " : ", ", range_text(writes->range),
                        values_text(request, writes->range));
  }
  return text;
}

}  // namespace

std::string identity_text(const Asker& asker) {
  using Kind = routing::ClientRole::Kind;
  std::string text;
  switch (asker.role.kind) {
    case Kind::none: return "";
    case Kind::named:
      text = asker.role.name.empty() ? "no role" : "role " + quoted(asker.role.name);
      break;
    case Kind::unreadable: text = "its role cannot be read"; break;
  }
  if (!asker.role.certificate.empty()) {
    text += ", certificate " + quoted(asker.role.certificate);
  }
  return fmt::format(" ({})", text);
}

std::string request_text(const Asked& asked) {
  const Bytes bytes(asked.pdu.data(), asked.pdu.size());
  const std::string text = fmt::format("function {} at unit {}", bytes[0], asked.unit);
  const auto pdu = modbus::Pdu::from(bytes);
  const auto request = modbus::Request::parse(*pdu);
  const bool has_registers = request && (request->reads() || request->writes());
  return text + (has_registers ? registers_text(*request) : data_text(bytes));
}

}  // namespace mbgate::report
