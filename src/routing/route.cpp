// SPDX-License-Identifier: Apache-2.0
#include "routing/route.hpp"

#include <algorithm>
#include <ranges>

#include "drive/values.hpp"
#include "modbus/codes.hpp"

namespace mbgate::routing {
namespace {

constexpr std::uint8_t kDiagnostics = 8;

using modbus::ExceptionCode;
using modbus::Table;
using modbus::TableRange;

// Nothing if there is no range, or no window that it lies in.
std::optional<TableRange> moved(std::span<const AddressWindow> windows,
                                const std::optional<modbus::AddressField>& field) {
  const auto window = std::ranges::find_if(windows, [&](const AddressWindow& it) {
    return field && field->range.table == it.table && field->range.first >= it.from &&
           drive::end_of(field->range) <= std::uint32_t{it.from} + it.count;
  });
  if (window == windows.end()) {
    return std::nullopt;
  }
  const TableRange& range = field->range;
  return TableRange{window->to_table,
                    static_cast<std::uint16_t>(range.first - window->from + window->to),
                    range.count};
}

bool is_writable(Table table) { return table == Table::coils || table == Table::holding_registers; }

bool passes(const FunctionRules& rules, const modbus::Pdu& pdu) {
  const std::uint8_t function = pdu.function();
  if (function == kDiagnostics && pdu.size() >= 3) {
    switch (modbus::load_be16(pdu.bytes(), 1)) {
      case modbus::kModbusPlusStatistics: return false;
      case modbus::kRestartCommunications: return rules.restart_communications;
      case modbus::kChangeDelimiter: return rules.change_delimiter;
      case modbus::kForceListenOnly: return rules.force_listen_only;
      default: break;
    }
  }
  return modbus::is_request_function(function) && rules.allowed.test(function);
}

}  // namespace

std::bitset<128> FunctionRules::codes() const {
  auto codes = allowed;
  codes[kDiagnostics] =
      allowed[kDiagnostics] || restart_communications || force_listen_only || change_delimiter;
  return codes;
}

FunctionRules FunctionRules::all() {
  FunctionRules rules;
  rules.allowed.set();
  rules.allowed.reset(0);
  rules.change_delimiter = true;
  return rules;
}

FunctionRules FunctionRules::rewritable() {
  FunctionRules rules;
  for (const std::size_t function : {1U, 2U, 3U, 4U, 5U, 6U, 15U, 16U, 22U, 23U, 24U}) {
    rules.allowed.set(function);
  }
  return rules;
}

bool Route::may_write() const {
  const auto may_move = [this](std::size_t code) {
    const auto function = static_cast<std::uint8_t>(code);
    return functions.allowed.test(function) && !modbus::is_read({&function, 1}) &&
           function != kDiagnostics && function != 43;  // though no reads in every form
  };
  return access != Access::read_only &&
         std::ranges::any_of(std::views::iota(std::size_t{1}, functions.allowed.size()), may_move);
}

bool ResolvedRoute::leads_to(const drive::Device& server, std::uint8_t unit) const {
  return std::ranges::find(route.buses, server.bus) != route.buses.end() &&
         (is_broadcast() || server.stands_for(route.address_of(unit)));
}

Result<modbus::Request, ExceptionCode> through_windows(std::span<const AddressWindow> windows,
                                                       const modbus::Request& request) {
  if (windows.empty()) {
    return request;
  }
  const auto reads = moved(windows, request.reads());
  const auto writes = moved(windows, request.writes());
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

std::optional<Denial> denial_of(const ResolvedRoute& resolved, ClientRights rights,
                                const modbus::Pdu& pdu) {
  const Route& route = resolved.route;
  const bool reads = modbus::is_read(pdu.bytes());
  if (rights.read_only && !reads) {
    return Denial::read_only_client;
  }
  if (route.access == Access::read_only && !reads) {
    return Denial::read_only_route;
  }
  if (!passes(route.functions, pdu)) {
    return Denial::functions;
  }
  if (resolved.is_broadcast() && !modbus::is_broadcast_function(pdu.function())) {
    return Denial::no_broadcast;
  }
  return std::nullopt;
}

}  // namespace mbgate::routing
