// SPDX-License-Identifier: Apache-2.0
#include "modbus/describe.hpp"

#include <array>
#include <fmt/format.h>

#include "modbus/mbap.hpp"
#include "modbus/response.hpp"

namespace mbgate::modbus {
namespace {

std::string name_of(std::uint8_t function) {
  const auto name = function_name(function);
  return name.empty() ? fmt::format("function {}", function) : std::string(name);
}

std::string opaque(Bytes pdu) {
  return fmt::format("{}, {} bytes", name_of(pdu[0]), pdu.size() - 1);
}

std::string malformed(Bytes pdu) {
  return fmt::format("{}, malformed: {}", name_of(pdu[0]), hex(pdu));
}

std::string registers(Bytes data) {
  const std::size_t count = data.size() / 2;
  std::string text = fmt::format("{} register{}:", count, count == 1 ? "" : "s");
  for (std::size_t at = 0; at + 1 < data.size(); at += 2) {
    text += fmt::format(" 0x{:04X}", load_be16(data, at));
  }
  return text;
}

std::string written(const Request& request) {
  const Bytes bytes = request.pdu().bytes();
  const std::uint8_t function = request.function();
  if (function == 0x05 || function == 0x06) {
    return fmt::format(" = 0x{:04X}", load_be16(bytes, 3));
  }
  if (function == 0x10) {
    return " = " + registers(bytes.subspan(6));
  }
  return {};
}

std::string body(Bytes pdu, Direction direction) {
  return direction == Direction::request ? describe_request(pdu) : describe_response(pdu);
}

}  // namespace

std::string_view table_name(Table table) {
  constexpr std::array kNames{"coils", "discrete inputs", "holding registers", "input registers"};
  return kNames.at(static_cast<std::size_t>(table));
}

std::string addresses_text(const TableRange& range) {
  const unsigned first = range.first;
  return range.count == 1 ? std::to_string(first)
                          : fmt::format("{}..{}", first, first + range.count - 1U);
}

std::string hex(Bytes bytes) { return fmt::format("{:02X}", fmt::join(bytes, " ")); }

std::string describe_request(Bytes pdu) {
  const auto whole = Pdu::from(pdu);
  if (!whole) {
    return fmt::format("no PDU: {} bytes", pdu.size());
  }
  const auto request = Request::parse(*whole);
  if (!request) {
    return malformed(pdu);
  }
  if (request->function() == 0x17) {
    return fmt::format("{}, reads {}, writes {}", name_of(pdu[0]),
                       addresses_text(request->reads()->range),
                       addresses_text(request->writes()->range));
  }
  if (request->reads()) {
    return name_of(pdu[0]) + " " + addresses_text(request->reads()->range);
  }
  if (request->writes()) {
    return fmt::format("{} {}{}", name_of(pdu[0]), addresses_text(request->writes()->range),
                       written(*request));
  }
  return opaque(pdu);
}

std::string describe_response(Bytes pdu) {
  if (pdu.empty()) {
    return "no PDU: 0 bytes";
  }
  if ((pdu[0] & kExceptionBit) != 0) {
    return pdu.size() == 2 ? exception_text(pdu[1]) : "exception, malformed: " + hex(pdu);
  }
  const PduLength length = response_length(pdu);
  if (length.kind == PduLength::Kind::need_more ||
      (length.kind == PduLength::Kind::known && length.bytes != pdu.size())) {
    return malformed(pdu);
  }
  switch (pdu[0]) {
    case 0x01:
    case 0x02: return "bits: " + hex(pdu.subspan(2));
    case 0x03:
    case 0x04:
    case 0x17: return pdu.size() % 2 == 0 ? registers(pdu.subspan(2)) : malformed(pdu);
    case 0x05:
    case 0x06: return fmt::format("{} {} done", name_of(pdu[0]), load_be16(pdu, 1));
    case 0x0F:
    case 0x10:
      return fmt::format("{} {}: {} done", name_of(pdu[0]), load_be16(pdu, 1), load_be16(pdu, 3));
    default: return opaque(pdu);
  }
}

std::string describe_adu(const RtuAdu& adu, Direction direction) {
  return fmt::format("unit {}: {}", adu.address, body(adu.pdu.bytes(), direction));
}

std::string describe_rtu(Bytes frame, Direction direction) {
  const auto adu = decode_rtu(frame);
  return adu ? describe_adu(*adu, direction) : "not an RTU frame (size or CRC): " + hex(frame);
}

std::string describe_mbap(Bytes adu, Direction direction) {
  const MbapScan scan = scan_mbap(adu);
  if (const auto* frame = std::get_if<MbapFrame>(&scan)) {
    const MbapHeader& header = frame->adu.header;
    return fmt::format("transaction {} unit {}: {}", header.transaction, header.unit,
                       body(frame->adu.pdu.bytes(), direction));
  }
  if (const auto* foreign = std::get_if<MbapForeign>(&scan)) {
    return fmt::format("protocol identifier {} instead of 0: {}", foreign->protocol, hex(adu));
  }
  if (const auto* lost = std::get_if<MbapLost>(&scan)) {
    return fmt::format("length {}, not 2 to 254: {}", lost->length, hex(adu));
  }
  return "incomplete: " + hex(adu);
}

}  // namespace mbgate::modbus
