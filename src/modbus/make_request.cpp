// SPDX-License-Identifier: Apache-2.0
#include "modbus/make_request.hpp"

#include <boost/container/static_vector.hpp>

namespace mbgate::modbus {
namespace {

class PduWriter {
 public:
  explicit PduWriter(FunctionCode function) { add(static_cast<std::uint8_t>(function)); }
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

FunctionCode read_function(Table table) {
  switch (table) {
    case Table::coils: return FunctionCode::read_coils;
    case Table::discrete_inputs: return FunctionCode::read_discrete_inputs;
    case Table::holding_registers: return FunctionCode::read_holding_registers;
    case Table::input_registers: return FunctionCode::read_input_registers;
  }
  return FunctionCode::read_holding_registers;
}

}  // namespace

Request make_read(const TableRange& range) {
  return PduWriter(read_function(range.table)).add(range).request();
}

Request make_single_write(Table table, std::uint16_t address, std::uint16_t value) {
  const auto function =
      table == Table::coils ? FunctionCode::write_single_coil : FunctionCode::write_single_register;
  return PduWriter(function).add16(address).add16(value).request();
}

Request make_multiple_write(const TableRange& range, Bytes data) {
  const auto function = range.table == Table::coils ? FunctionCode::write_multiple_coils
                                                    : FunctionCode::write_multiple_registers;
  return PduWriter(function).add(range).add_counted(data).request();
}

Request make_read_write(const TableRange& read, const TableRange& write, Bytes data) {
  return PduWriter(FunctionCode::read_write_multiple_registers)
      .add(read)
      .add(write)
      .add_counted(data)
      .request();
}

}  // namespace mbgate::modbus
