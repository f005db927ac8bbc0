// SPDX-License-Identifier: Apache-2.0
#include "modbus/response.hpp"

#include <algorithm>

namespace mbgate::modbus {
namespace {

using Kind = PduLength::Kind;

PduLength known(std::size_t bytes) { return {Kind::known, bytes}; }

PduLength unknown(Bytes /*prefix*/) { return {Kind::opaque}; }

template <std::size_t Size>
PduLength fixed(Bytes /*prefix*/) {
  return known(Size);
}

// The byte count at this offset counts all that follows it.
template <std::size_t Offset>
PduLength counted(Bytes prefix) {
  return prefix.size() <= Offset ? PduLength{Kind::need_more} : known(Offset + 1 + prefix[Offset]);
}

// 24: a 16-bit byte count (6.18).
PduLength fifo(Bytes prefix) {
  return prefix.size() < 3 ? PduLength{Kind::need_more}
                           : known(std::size_t{3} + load_be16(prefix, 1));
}

// 43/14: six fields, then objects of id, length, value (6.21). Other MEI types are opaque.
PduLength identification(Bytes prefix) {
  if (prefix.size() < 2) {
    return {Kind::need_more};
  }
  if (prefix[1] != kReadDeviceIdentification) {
    return {Kind::opaque};
  }
  if (prefix.size() < 7) {
    return {Kind::need_more};
  }
  std::size_t end = 7;
  for (unsigned object = 0; object < prefix[6]; ++object) {
    if (prefix.size() < end + 2) {
      return {Kind::need_more};
    }
    end += std::size_t{2} + prefix[end + 1];
  }
  return known(end);
}

/// A function, its name, and how long its requests and responses are.
struct Function {
  std::uint8_t code;
  std::string_view name;
  PduLength (*request)(Bytes prefix);
  PduLength (*response)(Bytes prefix);
};

constexpr Function kFunctions[] = {
    {0x01, "read coils", fixed<5>, counted<1>},
    {0x02, "read discrete inputs", fixed<5>, counted<1>},
    {0x03, "read holding registers", fixed<5>, counted<1>},
    {0x04, "read input registers", fixed<5>, counted<1>},
    {0x05, "write single coil", fixed<5>, fixed<5>},
    {0x06, "write single register", fixed<5>, fixed<5>},
    {0x07, "read exception status", fixed<1>, fixed<2>},
    {0x08, "diagnostics", unknown, unknown},
    {0x0B, "get comm event counter", fixed<1>, fixed<5>},
    {0x0C, "get comm event log", fixed<1>, counted<1>},
    {0x0F, "write multiple coils", counted<5>, fixed<5>},
    {0x10, "write multiple registers", counted<5>, fixed<5>},
    {0x11, "report server id", fixed<1>, counted<1>},
    {0x14, "read file record", counted<1>, counted<1>},
    {0x15, "write file record", counted<1>, counted<1>},
    {0x16, "mask write register", fixed<7>, fixed<7>},
    {0x17, "read/write multiple registers", counted<9>, counted<1>},
    {0x18, "read fifo queue", fixed<3>, fifo},
    {0x2B, "encapsulated interface", unknown, identification},
};

const Function& function_of(std::uint8_t code) {
  static constexpr Function kUnknown{0, {}, unknown, unknown};
  const auto* known = std::ranges::find(kFunctions, code, &Function::code);
  return known == std::end(kFunctions) ? kUnknown : *known;
}

// 20: of each group a length, the reference type and as many registers as were asked for; the
// request names them in sub-requests of seven bytes (6.14).
bool fits_file_record(Bytes request, Bytes response) {
  constexpr std::size_t kRecordRequest = 7;
  constexpr std::size_t kFileReferenceType = 6;
  std::size_t group = 2;
  for (std::size_t at = 2; at < request.size(); at += kRecordRequest) {
    const std::size_t size = std::size_t{2} + std::size_t{load_be16(request, at + 5)} * 2U;
    if (response.size() < group + size || response[group] != size - 1 ||
        response[group + 1] != kFileReferenceType) {
      return false;
    }
    group += size;
  }
  return response.size() == group;
}

// 24: the byte count counts the FIFO count and the registers behind it (6.18).
bool fits_fifo(Bytes response) {
  return response.size() >= 5 &&
         load_be16(response, 1) == std::size_t{2} + std::size_t{load_be16(response, 3)} * 2U;
}

bool repeats(Bytes request, Bytes response, std::size_t bytes) {
  return std::ranges::equal(request.first(bytes), response.first(bytes));
}

}  // namespace

PduLength response_length(Bytes prefix) {
  if ((prefix[0] & kExceptionBit) != 0) {
    return known(2);
  }
  return function_of(prefix[0]).response(prefix);
}

PduLength expected_response_length(const Request& request) {
  switch (request.function()) {
    case 0x01:
    case 0x02: return known(2U + (request.reads()->range.count + 7U) / 8U);
    case 0x03:
    case 0x04:
    case 0x17: return known(2U + std::size_t{request.reads()->range.count} * 2U);
    case 0x08:
    case 0x15: return known(request.pdu().size());
    case 0x2B: return identification(request.pdu().bytes().first(2));
    // The others do not depend on what was asked: their function code says all that is known.
    default: return response_length(request.pdu().bytes().first(1));
  }
}

ResponseFit check_response(const Request& request, Bytes response) {
  if (response[0] == (request.function() | kExceptionBit)) {
    return response.size() == 2 ? ResponseFit::exception : ResponseFit::wrong_length;
  }
  if (response[0] != request.function()) {
    return ResponseFit::wrong_function;
  }
  const PduLength expected = expected_response_length(request);
  const PduLength own = response_length(response);
  if ((expected.kind == Kind::known && expected.bytes != response.size()) ||
      (own.kind == Kind::known && own.bytes != response.size()) || own.kind == Kind::need_more) {
    return ResponseFit::wrong_length;
  }
  const Bytes asked = request.pdu().bytes();
  bool echo = true;
  switch (request.function()) {
    case 0x05:
    case 0x06:
    case 0x0F:
    case 0x10: echo = repeats(asked, response, 5); break;
    case 0x15:
    case 0x16: echo = repeats(asked, response, asked.size()); break;
    case 0x14: echo = fits_file_record(asked, response); break;
    case 0x18: echo = fits_fifo(response); break;
    // 08/00 returns its data, the other sub-functions data of their own (6.8).
    case 0x08: echo = repeats(asked, response, load_be16(asked, 1) == 0 ? asked.size() : 3); break;
    case 0x2B: echo = response.size() >= 2 && response[1] == asked[1]; break;
    default: break;
  }
  return echo ? ResponseFit::normal : ResponseFit::wrong_echo;
}

PduLength request_length(Bytes prefix) { return function_of(prefix[0]).request(prefix); }

std::string_view function_name(std::uint8_t function) { return function_of(function).name; }

}  // namespace mbgate::modbus
