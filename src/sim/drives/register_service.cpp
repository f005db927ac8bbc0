// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/register_service.hpp"

#include <algorithm>
#include <array>

namespace mbgate::sim {
namespace {

void append_registers(std::vector<std::uint8_t>& bytes, const Registers& words) {
  bytes.push_back(static_cast<std::uint8_t>(words.size() * 2));
  for (const std::uint16_t word : words) {
    bytes.push_back(static_cast<std::uint8_t>(word >> 8U));
    bytes.push_back(static_cast<std::uint8_t>(word & 0xFFU));
  }
}

// Application Protocol V1.1b3, 6.1: the first bit is the lowest of the first byte.
void append_bits(std::vector<std::uint8_t>& bytes, const Registers& bits) {
  bytes.push_back(static_cast<std::uint8_t>((bits.size() + 7) / 8));
  for (std::size_t i = 0; i < bits.size(); ++i) {
    if (i % 8 == 0) {
      bytes.push_back(0);
    }
    bytes.back() = static_cast<std::uint8_t>(bytes.back() | (bits[i] << (i % 8)));
  }
}

}  // namespace

ExceptionByte code_of(Refusal refusal, const RegisterRules& rules) {
  switch (refusal) {
    case Refusal::no_such_register: return rules.no_such_register;
    case Refusal::not_readable: return rules.not_readable;
    case Refusal::not_writable: return rules.not_writable;
    case Refusal::out_of_range: return rules.out_of_range;
  }
  return rules.no_such_register;
}

Registers written_words(const modbus::Request& request) {
  const modbus::TableRange& range = request.writes()->range;
  Registers words;
  for (std::size_t at = 0; at < range.count; ++at) {
    const std::uint16_t word = *request.written(static_cast<std::uint16_t>(range.first + at));
    words.push_back(range.table == modbus::Table::coils && word != 0 ? 1 : word);
  }
  return words;
}

modbus::Pdu exception(std::uint8_t function, ExceptionByte code) {
  const std::array<std::uint8_t, 2> bytes{
      static_cast<std::uint8_t>(function | modbus::kExceptionBit), code};
  return *modbus::Pdu::from(bytes);
}

Result<modbus::Request, Reaction> request_of(const modbus::Pdu& pdu,
                                             std::initializer_list<std::uint8_t> functions,
                                             ExceptionByte refusal) {
  if (std::ranges::find(functions, pdu.function()) == functions.end()) {
    return Reaction{exception(pdu.function(), refusal)};
  }
  const auto request = modbus::Request::parse(pdu);
  if (!request) {
    return Reaction{modbus::Pdu::exception(pdu.function(), request.error())};
  }
  return *request;
}

modbus::Pdu serve_read(const modbus::Request& request, const RegisterBank& bank,
                       const RegisterRules& rules) {
  const modbus::TableRange& range = request.reads()->range;
  if (range.count > rules.most_read) {
    return exception(request.function(), rules.too_many);
  }
  const auto words = bank.read(range.first, range.count);
  if (!words) {
    return exception(request.function(), code_of(words.error(), rules));
  }
  std::vector<std::uint8_t> bytes{request.function()};
  const bool bits = request.function() <= 0x02;
  bits ? append_bits(bytes, *words) : append_registers(bytes, *words);
  return *modbus::Pdu::from(bytes);
}

modbus::Pdu serve_write(const modbus::Request& request, RegisterBank& bank,
                        const RegisterRules& rules) {
  const modbus::TableRange& range = request.writes()->range;
  if (range.count > rules.most_written) {
    return exception(request.function(), rules.too_many);
  }
  if (const auto refusal = bank.write(range.first, written_words(request))) {
    return exception(request.function(), code_of(*refusal, rules));
  }
  return modbus::echo_response(request);
}

}  // namespace mbgate::sim
