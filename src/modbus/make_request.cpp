// SPDX-License-Identifier: Apache-2.0
#include "modbus/make_request.hpp"

#include <boost/container/static_vector.hpp>
#include <vector>

namespace mbgate::modbus {
namespace {

constexpr std::uint16_t kCoilOn = 0xFF00;

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

std::uint8_t read_function(Table table) {
  switch (table) {
    case Table::coils: return 1;
    case Table::discrete_inputs: return 2;
    case Table::holding_registers: return 3;
    case Table::input_registers: return 4;
  }
  return 3;
}

}  // namespace

Request make_read(const TableRange& range) {
  return PduWriter(read_function(range.table)).add(range).request();
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
