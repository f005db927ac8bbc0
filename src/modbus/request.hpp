// SPDX-License-Identifier: Apache-2.0
// A request that is well formed: its length fits its function, quantities are within the limits of
// the Application Protocol V1.1b3, addresses stay below 65536. Unknown functions are accepted as
// they are.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "modbus/pdu.hpp"
#include "modbus/result.hpp"

namespace mbgate::modbus {

/// The four primary tables (Application Protocol V1.1b3, 4.3), in the order of the functions that
/// read them.
enum class Table : std::uint8_t { coils, discrete_inputs, holding_registers, input_registers };

/// Coils and discrete inputs; the others hold registers.
constexpr bool holds_bits(Table table) {
  return table == Table::coils || table == Table::discrete_inputs;
}

/// Registers or bits `first` .. `first + count - 1` of a table; never beyond address 65535.
struct TableRange {
  Table table;
  std::uint16_t first;
  std::uint16_t count;
  friend bool operator==(const TableRange&, const TableRange&) = default;
};

/// A range that a request names, and where in the PDU its address field lies.
struct AddressField {
  TableRange range;
  std::size_t offset;
};

class Request {
 public:
  /// Errors: illegal_function for function 0 and 128-255; illegal_data_value where the length does
  /// not fit the function, a quantity is 0 or over its limit, or a coil is neither 0000 nor FF00
  /// (6.1-6.18); illegal_data_address where address + quantity exceeds 65536.
  static Result<Request, ExceptionCode> parse(const Pdu& pdu);

  [[nodiscard]] const Pdu& pdu() const { return pdu_; }
  [[nodiscard]] std::uint8_t function() const { return pdu_.function(); }
  [[nodiscard]] bool is_read() const { return is_read_; }
  /// What the request reads from a table: 01-04, 23, 24 (only the pointer register of 24).
  [[nodiscard]] const std::optional<AddressField>& reads() const { return reads_; }
  /// What it writes to a table: 05, 06, 15, 16, 22, 23.
  [[nodiscard]] const std::optional<AddressField>& writes() const { return writes_; }
  /// What a write (05, 06, 15, 16, 23) writes to `address`, a coil as 0000 or FF00. Nothing if it
  /// does not write there, or writes only some bits of the register (22).
  [[nodiscard]] std::optional<std::uint16_t> written(std::uint16_t address) const;
  /// The same request with another start address: reads()->offset or writes()->offset moved to
  /// `first`. The caller keeps first + count within 65536.
  [[nodiscard]] Request with_addresses(std::optional<std::uint16_t> read_first,
                                       std::optional<std::uint16_t> write_first) const;

 private:
  explicit Request(const Pdu& pdu) : pdu_(pdu), is_read_(modbus::is_read(pdu.bytes())) {}
  std::optional<ExceptionCode> parse_fields();
  std::optional<ExceptionCode> parse_reads(Table table, std::uint16_t limit);
  /// One register or coil, in a request of a fixed size.
  std::optional<ExceptionCode> parse_one(std::optional<AddressField>& field, Table table,
                                         std::size_t size);
  std::optional<ExceptionCode> parse_multiple_write(Table table, std::uint16_t limit);
  std::optional<ExceptionCode> parse_read_write();

  Pdu pdu_;
  bool is_read_;
  std::optional<AddressField> reads_;
  std::optional<AddressField> writes_;
};

/// The normal response to a write that repeats fields of its request (05, 06, 15, 16, 22; 08
/// repeats all): what a client gets after a broadcast. For other functions it is the unchanged
/// request.
Pdu echo_response(const Request& request);

// Requests made rather than received. The caller keeps quantities and addresses within the limits
// of the Application Protocol V1.1b3, section 6; register data are bytes, high byte first.

/// 01 to 04, by the table.
Request make_read(const TableRange& range);
/// 05 (`value` is 0000 or FF00) or 06, by the table.
Request make_single_write(Table table, std::uint16_t address, std::uint16_t value);
/// 15 (bits packed as on the wire) or 16, by the table.
Request make_multiple_write(const TableRange& range, Bytes data);
/// 05 or 06 for one value, 15 or 16 for several, or if `multiple`. A coil is off where its value is
/// 0.
Request make_write(Table table, std::uint16_t first, std::span<const std::uint16_t> values,
                   bool multiple = false);
/// 23.
Request make_read_write(const TableRange& read, const TableRange& write, Bytes data);

}  // namespace mbgate::modbus
