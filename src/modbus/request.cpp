// SPDX-License-Identifier: Apache-2.0
#include "modbus/request.hpp"

#include <boost/container/static_vector.hpp>
#include <vector>

namespace mbgate::modbus {
namespace {

using enum ExceptionCode;
using MaybeError = std::optional<ExceptionCode>;

constexpr std::uint16_t kMaxReadBits = 2000;        // 6.1, 6.2
constexpr std::uint16_t kMaxReadRegisters = 125;    // 6.3, 6.4, 6.17
constexpr std::uint16_t kMaxWriteBits = 1968;       // 6.11
constexpr std::uint16_t kMaxWriteRegisters = 123;   // 6.12
constexpr std::uint16_t kMaxReadWriteWrites = 121;  // 6.17
constexpr std::size_t kFileSubRequest = 7;          // 6.14

bool is_quantity(std::uint16_t count, std::uint16_t limit) { return count > 0 && count <= limit; }

MaybeError check_addresses(const TableRange& range) {
  return std::uint32_t{range.first} + range.count > 0x10000U ? illegal_data_address : MaybeError{};
}

std::size_t data_size(Table table, std::uint16_t count) {
  return holds_bits(table) ? (count + 7U) / 8U : std::size_t{count} * 2U;
}

// Functions 07, 11, 12 and 17 carry nothing but their code (6.7, 6.9, 6.10, 6.13).
MaybeError check_size(const Pdu& pdu, std::size_t size) {
  return pdu.size() == size ? MaybeError{} : illegal_data_value;
}

// 20 and 21: a byte count of all that follows, and sub-requests of 7 bytes each, of which the last
// two are the number of registers. In 21 these follow (6.14, 6.15).
MaybeError check_file_record(const Pdu& pdu, std::size_t smallest, std::size_t largest) {
  constexpr std::uint8_t kReferenceType = 6;
  constexpr std::size_t kRecordLength = 5;
  Bytes rest = pdu.bytes();
  if (rest.size() < 2 || rest[1] < smallest || rest[1] > largest || rest[1] != rest.size() - 2) {
    return illegal_data_value;
  }
  for (rest = rest.subspan(2); !rest.empty();) {
    if (rest.size() < kFileSubRequest || rest[0] != kReferenceType) {
      return illegal_data_value;
    }
    const std::size_t registers =
        pdu.function() == 0x14 ? 0 : modbus::load_be16(rest, kRecordLength);
    if (rest.size() < kFileSubRequest + 2 * registers) {
      return illegal_data_value;
    }
    rest = rest.subspan(kFileSubRequest + 2 * registers);
  }
  return {};
}

// 08: a sub-function and at least one 16-bit data field (6.8).
MaybeError check_diagnostics(const Pdu& pdu) {
  return pdu.size() >= 5 && pdu.size() % 2 == 1 ? MaybeError{} : illegal_data_value;
}

// 43/14 carries a code and an object (6.21); other MEI types are opaque.
MaybeError check_encapsulated(const Pdu& pdu) {
  if (pdu.size() < 2) {
    return illegal_data_value;
  }
  return pdu.bytes()[1] == kReadDeviceIdentification ? check_size(pdu, 4) : MaybeError{};
}

constexpr std::uint16_t kCoilOn = 0xFF00;

// 05: nothing else than on and off (6.5).
bool is_coil_value(const Pdu& pdu) {
  const std::uint16_t value = pdu.size() == 5 ? load_be16(pdu.bytes(), 3) : std::uint16_t{1};
  return value == 0 || value == kCoilOn;
}

class PduWriter {
 public:
  explicit PduWriter(std::uint8_t function) { add(function); }
  PduWriter& add(std::uint8_t byte) {
    bytes_.push_back(byte);
    return *this;
  }
  PduWriter& add16(std::uint16_t field) {
    return add(static_cast<std::uint8_t>(field >> 8U))
        .add(static_cast<std::uint8_t>(field & 0xFFU));
  }
  /// Address and quantity.
  PduWriter& add(const TableRange& range) { return add16(range.first).add16(range.count); }
  /// A byte count and what it counts.
  PduWriter& add_counted(Bytes data) {
    add(static_cast<std::uint8_t>(data.size()));
    bytes_.insert(bytes_.end(), data.begin(), data.end());
    return *this;
  }
  [[nodiscard]] Request request() const {
    return *Request::parse(*Pdu::from({bytes_.data(), bytes_.size()}));
  }

 private:
  boost::container::static_vector<std::uint8_t, kMaxPduSize> bytes_;
};

}  // namespace

Result<Request, ExceptionCode> Request::parse(const Pdu& pdu) {
  if (!is_request_function(pdu.function())) {
    return illegal_function;
  }
  Request request(pdu);
  if (const auto error = request.parse_fields()) {
    return *error;
  }
  return request;
}

std::optional<ExceptionCode> Request::parse_fields() {
  switch (pdu_.function()) {
    case 0x01: return parse_reads(Table::coils, kMaxReadBits);
    case 0x02: return parse_reads(Table::discrete_inputs, kMaxReadBits);
    case 0x03: return parse_reads(Table::holding_registers, kMaxReadRegisters);
    case 0x04: return parse_reads(Table::input_registers, kMaxReadRegisters);
    case 0x05:
      return is_coil_value(pdu_) ? parse_one(writes_, Table::coils, 5) : illegal_data_value;
    case 0x06: return parse_one(writes_, Table::holding_registers, 5);
    case 0x07:
    case 0x0B:
    case 0x0C:
    case 0x11: return check_size(pdu_, 1);
    case 0x08: return check_diagnostics(pdu_);
    case 0x0F: return parse_multiple_write(Table::coils, kMaxWriteBits);
    case 0x10: return parse_multiple_write(Table::holding_registers, kMaxWriteRegisters);
    case 0x14: return check_file_record(pdu_, 7, 0xF5);
    case 0x15: return check_file_record(pdu_, 9, 0xFB);
    case 0x16: return parse_one(writes_, Table::holding_registers, 7);
    case 0x17: return parse_read_write();
    case 0x18: return parse_one(reads_, Table::holding_registers, 3);
    case 0x2B: return check_encapsulated(pdu_);
    default: return std::nullopt;
  }
}

std::optional<ExceptionCode> Request::parse_reads(Table table, std::uint16_t limit) {
  if (pdu_.size() != 5) {
    return illegal_data_value;
  }
  const TableRange range{table, load_be16(pdu_.bytes(), 1), load_be16(pdu_.bytes(), 3)};
  reads_ = AddressField{range, 1};
  return is_quantity(range.count, limit) ? check_addresses(range) : illegal_data_value;
}

std::optional<ExceptionCode> Request::parse_one(std::optional<AddressField>& field, Table table,
                                                std::size_t size) {
  if (pdu_.size() != size) {
    return illegal_data_value;
  }
  field = AddressField{{table, load_be16(pdu_.bytes(), 1), 1}, 1};
  return std::nullopt;
}

std::optional<ExceptionCode> Request::parse_multiple_write(Table table, std::uint16_t limit) {
  if (pdu_.size() < 6) {
    return illegal_data_value;
  }
  const Bytes bytes = pdu_.bytes();
  const TableRange range{table, load_be16(bytes, 1), load_be16(bytes, 3)};
  const std::size_t size = data_size(table, range.count);
  if (bytes[5] != size || bytes.size() != 6 + size) {
    return illegal_data_value;
  }
  writes_ = AddressField{range, 1};
  return is_quantity(range.count, limit) ? check_addresses(range) : illegal_data_value;
}

std::optional<ExceptionCode> Request::parse_read_write() {
  const Bytes bytes = pdu_.bytes();
  if (bytes.size() < 10) {
    return illegal_data_value;
  }
  const TableRange read{Table::holding_registers, load_be16(bytes, 1), load_be16(bytes, 3)};
  const TableRange write{Table::holding_registers, load_be16(bytes, 5), load_be16(bytes, 7)};
  const std::size_t size = std::size_t{write.count} * 2U;
  if (bytes[9] != size || bytes.size() != 10 + size) {
    return illegal_data_value;
  }
  reads_ = AddressField{read, 1};
  writes_ = AddressField{write, 5};
  if (!is_quantity(read.count, kMaxReadRegisters) ||
      !is_quantity(write.count, kMaxReadWriteWrites)) {
    return illegal_data_value;
  }
  const auto error = check_addresses(read);
  return error ? error : check_addresses(write);
}

std::optional<std::uint16_t> Request::written(std::uint16_t address) const {
  if (!writes_ || address < writes_->range.first ||
      address - writes_->range.first >= writes_->range.count) {
    return std::nullopt;
  }
  const std::size_t at = address - writes_->range.first;
  const Bytes bytes = pdu_.bytes();
  switch (function()) {
    case 0x05:
    case 0x06: return load_be16(bytes, 3);
    case 0x0F:
      return static_cast<std::uint16_t>(((bytes[6 + at / 8] >> (at % 8)) & 1U) != 0 ? 0xFF00 : 0);
    case 0x10: return load_be16(bytes, 6 + 2 * at);
    case 0x17: return load_be16(bytes, 10 + 2 * at);
    default: return std::nullopt;
  }
}

Request Request::with_addresses(std::optional<std::uint16_t> read_first,
                                std::optional<std::uint16_t> write_first) const {
  Request moved = *this;
  if (moved.reads_ && read_first) {
    moved.reads_->range.first = *read_first;
    moved.pdu_.set_be16(moved.reads_->offset, *read_first);
  }
  if (moved.writes_ && write_first) {
    moved.writes_->range.first = *write_first;
    moved.pdu_.set_be16(moved.writes_->offset, *write_first);
  }
  return moved;
}

Pdu echo_response(const Request& request) {
  const bool multiple = request.function() == 0x0F || request.function() == 0x10;
  const Bytes bytes = request.pdu().bytes();
  // A part of a legal PDU, five bytes of at least six, is a legal PDU.
  return multiple ? *Pdu::from(bytes.first(5)) : request.pdu();
}

Request make_read(const TableRange& range) {
  const auto function = static_cast<unsigned>(range.table) + 1;  // 01 to 04, in their order
  return PduWriter(static_cast<std::uint8_t>(function)).add(range).request();
}

Request make_single_write(Table table, std::uint16_t address, std::uint16_t value) {
  return PduWriter(table == Table::coils ? 5 : 6).add16(address).add16(value).request();
}

Request make_multiple_write(const TableRange& range, Bytes data) {
  return PduWriter(range.table == Table::coils ? 15 : 16).add(range).add_counted(data).request();
}

Request make_write(Table table, std::uint16_t first, std::span<const std::uint16_t> values,
                   bool multiple) {
  const bool bits = table == Table::coils;
  if (values.size() == 1 && !multiple) {
    return make_single_write(table, first, bits && values[0] != 0 ? kCoilOn : values[0]);
  }
  std::vector<std::uint8_t> data(bits ? (values.size() + 7) / 8 : 2 * values.size());
  for (std::size_t at = 0; at < values.size(); ++at) {
    if (!bits) {
      store_be16(data, 2 * at, values[at]);
    } else if (values[at] != 0) {
      data[at / 8] = static_cast<std::uint8_t>(data[at / 8] | (1U << (at % 8)));
    }
  }
  return make_multiple_write({table, first, static_cast<std::uint16_t>(values.size())}, data);
}

Request make_read_write(const TableRange& read, const TableRange& write, Bytes data) {
  return PduWriter(23).add(read).add(write).add_counted(data).request();
}

}  // namespace mbgate::modbus
