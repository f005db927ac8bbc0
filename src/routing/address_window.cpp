// SPDX-License-Identifier: Apache-2.0
#include "routing/address_window.hpp"

#include <algorithm>

#include "drive/register_range.hpp"
#include "modbus/make_request.hpp"

namespace mbgate::routing {
namespace {

using modbus::ExceptionCode;
using modbus::Table;
using modbus::TableRange;

bool lies_within(const AddressWindow& window, const TableRange& range) {
  return range.table == window.table && range.first >= window.from &&
         drive::end_of(range) <= std::uint32_t{window.from} + window.count;
}

const AddressWindow* find(std::span<const AddressWindow> windows, const TableRange& range) {
  const auto window = std::ranges::find_if(
      windows, [&](const AddressWindow& it) { return lies_within(it, range); });
  return window == windows.end() ? nullptr : &*window;
}

std::optional<TableRange> moved(std::span<const AddressWindow> windows, const TableRange& range) {
  const AddressWindow* window = find(windows, range);
  if (window == nullptr) {
    return std::nullopt;
  }
  return TableRange{window->to_table,
                    static_cast<std::uint16_t>(range.first - window->from + window->to),
                    range.count};
}

bool is_writable(Table table) { return table == Table::coils || table == Table::holding_registers; }

}  // namespace

Result<modbus::Request, ExceptionCode> through_windows(std::span<const AddressWindow> windows,
                                                       const modbus::Request& request) {
  std::optional<TableRange> reads;
  std::optional<TableRange> writes;
  if (request.reads()) {
    reads = moved(windows, request.reads()->range);
  }
  if (request.writes()) {
    writes = moved(windows, request.writes()->range);
  }
  if (reads.has_value() != request.reads().has_value() ||
      writes.has_value() != request.writes().has_value()) {
    return ExceptionCode::illegal_data_address;
  }
  if (writes && !is_writable(writes->table)) {
    return ExceptionCode::illegal_function;
  }
  if (reads && reads->table != request.reads()->range.table) {
    if (request.function() > 0x04) {  // 23 and 24 read holding registers only
      return ExceptionCode::illegal_function;
    }
    return modbus::make_read(*reads);
  }
  return request.with_addresses(reads ? std::optional(reads->first) : std::nullopt,
                                writes ? std::optional(writes->first) : std::nullopt);
}

}  // namespace mbgate::routing
