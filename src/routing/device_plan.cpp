// SPDX-License-Identifier: Apache-2.0
#include "routing/device_plan.hpp"

#include <algorithm>
#include <vector>

namespace mbgate::routing {
namespace {

using drive::Value;
using drive::WordExchange;
using modbus::ExceptionCode;
using modbus::Request;
using modbus::Table;
using modbus::TableRange;

std::uint16_t count_between(std::uint32_t begin, std::uint32_t end) {
  return static_cast<std::uint16_t>(end - begin);
}

// One request being planned.
class Planner {
 public:
  Planner(const drive::Device& device, std::optional<drive::WordOrder> seen, const Request& request)
      : device_(device),
        profile_(device.profile),
        request_(request),
        seen_(seen),
        exchanging_(seen && device.word_order && *seen != *device.word_order) {}

  Result<DevicePlan, ExceptionCode> make();

 private:
  Result<DevicePlan, ExceptionCode> plan_read();
  Result<DevicePlan, ExceptionCode> plan_read_write();
  Result<DevicePlan, ExceptionCode> plan_register_write();
  Result<DevicePlan, ExceptionCode> plan_multiple_write();
  Result<DevicePlan, ExceptionCode> plan_coils();
  void run_of_singles(const TableRange& range, modbus::Bytes data, Requests& requests) const;
  [[nodiscard]] Reply data_of(const TableRange& range, const TableRange& asked) const;
  [[nodiscard]] TableRange widened(const TableRange& range) const;

  const drive::Device& device_;
  const drive::Profile& profile_;
  const Request& request_;
  std::optional<drive::WordOrder> seen_;
  bool exchanging_;  // the client's order is not the drive's
};

Result<DevicePlan, ExceptionCode> Planner::make() {
  const auto order = exchanging_ ? seen_ : device_.word_order;
  if (device_.is_reconfigured_by(request_, order) && !device_.allow_reconfigure) {
    return ExceptionCode::illegal_function;
  }
  if (seen_ && device_.has_uncertain_position(*seen_, request_)) {
    return ExceptionCode::illegal_data_value;
  }
  switch (request_.function()) {
    case 0x01:
    case 0x02:
    case 0x03:
    case 0x04: return plan_read();
    case 0x06:
    case 0x16: return plan_register_write();
    case 0x0F: return plan_coils();
    case 0x10: return plan_multiple_write();
    case 0x17: return plan_read_write();
    case 0x05: return DevicePlan{{request_}, {Reply::Form::echo}};
    default: return DevicePlan{{request_}, {}};
  }
}

TableRange Planner::widened(const TableRange& range) const {
  std::uint32_t begin = range.first;
  std::uint32_t end = drive::end_of(range);
  if (exchanging_) {
    if (const Value* first = profile_.values.at(range.table, begin)) {
      begin = first->first;
    }
    if (const Value* last = profile_.values.at(range.table, end - 1)) {
      end = last->end();
    }
  }
  return {range.table, static_cast<std::uint16_t>(begin), count_between(begin, end)};
}

// The answer to a read of `asked` out of all that was read of `range`.
Reply Planner::data_of(const TableRange& range, const TableRange& asked) const {
  return {data_form(asked.table), count_between(range.first, asked.first),
          exchanging_ ? WordExchange(profile_.values, range) : WordExchange()};
}

Result<DevicePlan, ExceptionCode> Planner::plan_read() {
  const TableRange& asked = request_.reads()->range;
  const TableRange known{profile_.described_in(asked.table), asked.first, asked.count};
  const bool input = known.table != asked.table;
  const TableRange range = widened(known);
  Table table = asked.table;
  if (input && (range.count > profile_.limits.read_from(table) || !profile_.functions.test(0x04))) {
    table = Table::holding_registers;
  }
  DevicePlan plan;
  plan.reply = data_of(range, asked);
  for (TableRange piece : cut(range, profile_.limits.read_from(table), profile_)) {
    piece.table = table;
    plan.requests.push_back(modbus::make_read(piece));
  }
  if (plan.requests.size() == 1 && range == asked && plan.reply.exchange.is_empty()) {
    plan.reply.form = Reply::Form::as_it_is;
  }
  return plan;
}

Result<DevicePlan, ExceptionCode> Planner::plan_read_write() {
  const TableRange& reads = request_.reads()->range;
  const TableRange& writes = request_.writes()->range;
  const TableRange range = widened(reads);
  // It reads and writes in one go, so it cannot be split.
  const bool fits = !device_.cuts_value(writes) &&
                    writes.count <= profile_.limits.write_registers &&
                    cut(writes, writes.count, profile_).size() == 1 &&
                    cut(range, profile_.limits.read_from(range.table), profile_).size() == 1;
  if (!fits) {
    return ExceptionCode::illegal_data_value;
  }
  DevicePlan plan;
  plan.requests.push_back(
      modbus::make_read_write(range, writes, device_.data_in_order(seen_, request_)));
  plan.reply = data_of(range, reads);
  return plan;
}

Result<DevicePlan, ExceptionCode> Planner::plan_register_write() {
  const TableRange& range = request_.writes()->range;
  const Value* value = profile_.values.at(range.table, range.first);
  if (value != nullptr && value->motion) {
    return ExceptionCode::illegal_data_value;
  }
  const std::uint16_t address =
      value != nullptr && exchanging_ ? drive::partner(*value, range.first) : range.first;
  DevicePlan plan{{request_.with_addresses(std::nullopt, address)}, {Reply::Form::echo}};
  if (request_.function() == 0x06 && device_.write_function == 0x10) {
    const modbus::Bytes data = request_.pdu().bytes().subspan(3);
    plan.requests[0] = modbus::make_multiple_write({range.table, address, 1}, data);
  }
  return plan;
}

Result<DevicePlan, ExceptionCode> Planner::plan_multiple_write() {
  const TableRange& range = request_.writes()->range;
  if (device_.cuts_value(range)) {
    return ExceptionCode::illegal_data_value;
  }
  const auto data = device_.data_in_order(seen_, request_);
  DevicePlan plan{{}, {Reply::Form::echo}};
  if (device_.write_function == 0x06) {
    run_of_singles(range, data, plan.requests);
    return plan;
  }
  const Pieces pieces = cut(range, profile_.limits.write_registers, profile_);
  // An opcode is carried out when it is written: nothing of its parameters may come later.
  const bool opcode = profile_.position_opcodes &&
                      drive::contains(range, range.table, profile_.position_opcodes->address);
  if (pieces.size() > 1 && (!device_.split_writes || opcode)) {
    return ExceptionCode::illegal_data_value;
  }
  for (const TableRange& piece : pieces) {
    plan.requests.push_back(modbus::make_multiple_write(
        piece, modbus::Bytes(data).subspan(std::size_t{count_between(range.first, piece.first)} * 2,
                                           std::size_t{piece.count} * 2)));
  }
  return plan;
}

// One 06 a register; the registers of a value, as many as are written, stay together in one 16
// unless they may be split.
void Planner::run_of_singles(const TableRange& range, modbus::Bytes data,
                             Requests& requests) const {
  for (std::uint32_t at = range.first; at < drive::end_of(range);) {
    const std::size_t offset = std::size_t{count_between(range.first, at)} * 2;
    const Value* value = profile_.values.at(range.table, at);
    const bool may_be_split = value == nullptr || (device_.split_values && !value->motion);
    const std::uint32_t end = may_be_split ? at + 1 : std::min(value->end(), drive::end_of(range));
    const auto first = static_cast<std::uint16_t>(at);
    const auto count = static_cast<std::uint16_t>(end - at);
    requests.push_back(
        count > 1 ? modbus::make_multiple_write({range.table, first, count},
                                                data.subspan(offset, std::size_t{count} * 2))
                  : modbus::make_single_write(range.table, first, modbus::load_be16(data, offset)));
    at = end;
  }
}

Result<DevicePlan, ExceptionCode> Planner::plan_coils() {
  const TableRange& range = request_.writes()->range;
  const Pieces pieces = cut(range, profile_.limits.write_coils, profile_);
  if (pieces.size() == 1) {
    return DevicePlan{{request_}, {Reply::Form::echo}};
  }
  if (!device_.split_writes) {
    return ExceptionCode::illegal_data_value;
  }
  DevicePlan plan{{}, {Reply::Form::echo}};
  for (const TableRange& piece : pieces) {
    std::vector<std::uint16_t> coils;
    for (std::uint32_t at = piece.first; at < drive::end_of(piece); ++at) {
      coils.push_back(*request_.written(static_cast<std::uint16_t>(at)));
    }
    plan.requests.push_back(modbus::make_write(piece.table, piece.first, coils, true));
  }
  return plan;
}

}  // namespace

Pieces cut(const modbus::TableRange& range, std::uint16_t limit, const drive::Profile& profile) {
  Pieces pieces;
  const std::uint32_t end = drive::end_of(range);
  for (std::uint32_t at = range.first; at < end;) {
    std::uint32_t stop = std::min({end, at + limit, profile.group_end(range.table, at)});
    const drive::Value* value = profile.values.at(range.table, stop);
    if (stop < end && value != nullptr && value->first < stop && value->first > at) {
      stop = value->first;
    }
    pieces.push_back(
        {range.table, static_cast<std::uint16_t>(at), static_cast<std::uint16_t>(stop - at)});
    at = stop;
  }
  return pieces;
}

Result<DevicePlan, ExceptionCode> plan_for(const drive::Device& device,
                                           std::optional<drive::WordOrder> seen,
                                           const Request& request) {
  return Planner(device, seen, request).make();
}

}  // namespace mbgate::routing
