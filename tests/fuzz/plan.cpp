// SPDX-License-Identifier: Apache-2.0
// Any request to any drive by any route: what goes on the bus keeps to the drive's limits, and what
// the drive answers becomes an answer that fits the request.
#include "routing/plan.hpp"

#include <vector>

#include "fuzz/fuzz.hpp"
#include "fuzz/responses.hpp"
#include "modbus/response.hpp"

namespace mbgate::fuzz {
namespace {

using drive::WordOrder;
using modbus::ResponseFit;
using modbus::Table;

Table table_of(Script& script) { return static_cast<Table>(script.byte() % 4); }

WordOrder order_of(Script& script) { return script.flag() ? WordOrder::big : WordOrder::little; }

/// Consistent as the configuration makes profiles: a value is never over a limit, no group cuts
/// one.
void read_profile(Script& script, drive::Profile& profile) {
  const std::uint8_t values = script.byte() % 16;
  for (int value = 0; value < values; ++value) {
    const auto table = script.flag() ? Table::holding_registers : Table::input_registers;
    const auto registers = static_cast<std::uint8_t>(script.flag() ? 4 : 2);
    const std::uint16_t first = script.number(0xFFFF - 4);
    profile.values.add({table, first, registers, script.flag()});
  }
  profile.limits.read[2] = static_cast<std::uint16_t>(4 + script.number(122));
  profile.limits.read[3] = static_cast<std::uint16_t>(4 + script.number(122));
  profile.limits.read[0] = static_cast<std::uint16_t>(1 + script.number(2000));
  profile.limits.write_registers = static_cast<std::uint16_t>(4 + script.number(120));
  profile.limits.write_coils = static_cast<std::uint16_t>(1 + script.number(1968));
  profile.input_as_holding = script.flag();
  std::uint32_t begin = script.word();
  for (int groups = script.byte() % 4; groups > 0 && begin < 0xFF00; --groups) {
    std::uint32_t end = begin + 4 + script.byte() % 64;
    for (const std::uint32_t border : {begin, end}) {
      const auto* cut = profile.values.at(Table::holding_registers, border);
      if (cut != nullptr && cut->first < border) {
        return;
      }
    }
    profile.groups.push_back({Table::holding_registers, static_cast<std::uint16_t>(begin),
                              static_cast<std::uint16_t>(end - begin)});
    begin = end;
  }
}

drive::Device read_device(Script& script) {
  drive::Device device;
  read_profile(script, device.profile);
  const std::uint8_t rules = script.byte();
  device.word_order = order_of(script);
  device.split_values = (rules & 1U) != 0;
  device.split_writes = (rules & 2U) != 0;
  device.allow_reconfigure = (rules & 4U) != 0;
  if ((rules & 8U) != 0) {
    device.write_function = static_cast<std::uint8_t>((rules & 16U) != 0 ? 6 : 16);
  }
  return device;
}

routing::AddressWindow read_window(Script& script) {
  routing::AddressWindow window;
  window.table = table_of(script);
  const bool bits = window.table == Table::coils || window.table == Table::discrete_inputs;
  window.to_table = !script.flag() ? window.table
                    : bits         ? Table::discrete_inputs
                                   : Table::input_registers;
  window.from = script.word();
  window.to = script.word();
  window.count =
      std::min<std::uint32_t>(1U + script.word(), 0x10000U - std::max(window.from, window.to));
  return window;
}

void check_limits(const drive::Device& device, const modbus::Request& request) {
  const auto check = [&](const std::optional<modbus::AddressField>& field, std::uint16_t limit) {
    if (field) {
      require(field->range.count <= limit, "a transaction is within the drive's limits");
      require(device.profile.group_end(field->range.table, field->range.first) >=
                  drive::end_of(field->range),
              "a transaction stays in its parameter group");
    }
  };
  if (request.reads() && request.function() != 0x18) {
    check(request.reads(), device.profile.limits.read_from(request.reads()->range.table));
  }
  if (request.writes()) {
    check(request.writes(), device.profile.limits.written_to(request.writes()->range.table));
  }
}

void check_answer(const routing::Plan& plan, const modbus::Request& request, Script& script) {
  std::vector<modbus::Pdu> answers;
  for (const auto& transaction : plan.transactions()) {
    answers.push_back(response_to(transaction.request, script));
    const auto fit = modbus::check_response(transaction.request, answers.back().bytes());
    if (fit == ResponseFit::exception) {
      break;
    }
    if (fit != ResponseFit::normal) {
      return;  // no bus would take it
    }
  }
  std::vector<const modbus::Pdu*> pointers;
  for (const auto& answer : answers) {
    pointers.push_back(&answer);
  }
  const auto fit = modbus::check_response(request, plan.answer(pointers).bytes());
  require(fit == (answers.back().is_exception() ? ResponseFit::exception : ResponseFit::normal),
          "the answer fits the client's request");
}

}  // namespace
}  // namespace mbgate::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mbgate;
  using namespace mbgate::fuzz;
  Script script(data, size);
  const drive::Device device = read_device(script);
  routing::Way way;
  way.route.first_unit = way.route.last_unit = way.route.first_address = 1;
  way.route.buses = {device.bus};
  const bool known = script.flag();
  if (known) {
    way.device = &device;
    way.route.word_order = script.flag() ? std::optional(order_of(script)) : std::nullopt;
  }
  for (int windows = script.byte() % 3; windows > 0 && !known; --windows) {
    way.route.windows.push_back(read_window(script));
  }
  const auto pdu = modbus::Pdu::from(script.piece());
  if (!pdu || !modbus::is_request_function(pdu->function())) {
    return 0;
  }
  const auto plan = routing::Plan::make(way, 1, {script.flag()}, *pdu);
  if (!plan) {
    return 0;
  }
  const auto request = modbus::Request::parse(*pdu);
  require(request.has_value(), "a plan is made of a well-formed request only");
  require(!plan->transactions().empty(), "a plan does something");
  for (const auto& transaction : plan->transactions()) {
    require(modbus::Request::parse(transaction.request.pdu()).has_value(),
            "a transaction is well-formed");
    require(plan->is_read() <= transaction.request.is_read(), "a read writes nothing");
    if (known) {
      check_limits(device, transaction.request);
    }
  }
  check_answer(*plan, *request, script);
  return 0;
}
