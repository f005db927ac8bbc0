// SPDX-License-Identifier: Apache-2.0
#include "routing/broadcast_plan.hpp"

#include <algorithm>
#include <array>

#include "modbus/make_request.hpp"
#include "routing/special_writes.hpp"

namespace mbgate::routing {
namespace {

using drive::BroadcastForm;
using drive::Device;
using modbus::ExceptionCode;
using modbus::Request;
using modbus::TableRange;
using Receivers = std::vector<const Device*>;

constexpr std::array kForms{BroadcastForm::standard, BroadcastForm::autonics};

// Does the manual of this drive let such a broadcast reach it?
bool takes(const Device& device, const Request& request) {
  const auto& rules = device.profile.broadcast;
  const TableRange& range = request.writes()->range;
  return device.profile.functions.test(request.function()) &&
         (!rules.allowed || drive::covers(*rules.allowed, range)) &&
         (request.function() != 0x10 || !rules.most_registers ||
          range.count <= *rules.most_registers);
}

// Those that may carry the request out if it goes out in this form. At address 0 nobody can be kept
// from listening, not even a drive whose manual states no broadcasts; the AiC's form is known to be
// heard for what its manual lists, and only for that.
Receivers receivers_of(const Audience& audience, BroadcastForm form, const Request& request) {
  Receivers receivers;
  std::ranges::copy_if(audience.devices, std::back_inserter(receivers), [&](const Device* device) {
    if (form == BroadcastForm::autonics) {
      return device->profile.broadcast.form == form && takes(*device, request);
    }
    return device->profile.broadcast.form != BroadcastForm::autonics &&
           device->profile.functions.test(request.function());
  });
  return receivers;
}

// Is one of them there for whom the manual states this form?
bool is_meant(const Receivers& receivers, BroadcastForm form) {
  return std::ranges::any_of(receivers,
                             [&](const Device* it) { return it->profile.broadcast.form == form; });
}

bool same_values(const Device& a, const Device& b, const TableRange& range) {
  const drive::Value* one = a.profile.values.from(range.table, range.first);
  const drive::Value* other = b.profile.values.from(range.table, range.first);
  const auto within = [&](const drive::Value* value) {
    return value != nullptr && value->first < drive::end_of(range);
  };
  while (within(one) && within(other)) {
    if (one->first != other->first || one->registers != other->registers) {
      return false;
    }
    one = a.profile.values.from(range.table, one->end());
    other = b.profile.values.from(range.table, other->end());
  }
  return within(one) == within(other);
}

// What a value's words mean must be the same for all who hear them.
bool understand_alike(const Receivers& receivers, const Request& request) {
  const TableRange& range = request.writes()->range;
  if (std::ranges::none_of(receivers,
                           [&](const Device* it) { return touches_value(*it, request); })) {
    return true;
  }
  const Device& first = *receivers.front();
  return std::ranges::all_of(receivers, [&](const Device* it) {
    const bool same_order =
        it->word_order == first.word_order && (it->word_order.has_value() || receivers.size() == 1);
    return same_order && same_values(first, *it, range);
  });
}

bool cuts_value(const Device& device, const TableRange& range) {
  const auto& values = device.profile.values;
  const auto inside = [&](std::uint32_t border) {
    const drive::Value* value = values.at(range.table, border);
    return value != nullptr && value->first < border;
  };
  return inside(range.first) || inside(drive::end_of(range));
}

std::optional<ExceptionCode> objection(const Device& device, const Request& request) {
  const TableRange& range = request.writes()->range;
  if (device.is_reconfigured_by(request) && !device.allow_reconfigure) {
    return ExceptionCode::illegal_function;
  }
  if (device.profile.broadcast.form != BroadcastForm::none && !takes(device, request)) {
    return ExceptionCode::illegal_data_address;
  }
  const bool fits =
      range.count <= device.profile.limits.written_to(range.table) && !cuts_value(device, range);
  return fits ? std::nullopt : std::optional(ExceptionCode::illegal_data_value);
}

// The request with its values in the order that the device speaks; nothing where that is uncertain.
std::optional<Request> in_order_of(const Device& device, drive::WordOrder seen,
                                   const Request& request) {
  if (has_uncertain_position(device, seen, request)) {
    return std::nullopt;
  }
  return request.function() == 0x10
             ? modbus::make_multiple_write(request.writes()->range,
                                           data_in_order(device, seen, request))
             : request;
}

}  // namespace

Result<BroadcastFrames, ExceptionCode> plan_broadcast(const ResolvedRoute& resolved,
                                                      const Request& request) {
  BroadcastFrames frames;
  Receivers all;
  for (const Audience& audience : resolved.audiences) {
    for (const BroadcastForm form : kForms) {
      const Receivers receivers = receivers_of(audience, form, request);
      const bool unknown_devices = audience.devices.empty() && form == BroadcastForm::standard;
      const bool wanted = !resolved.only_form || *resolved.only_form == form;
      if (wanted && (unknown_devices || is_meant(receivers, form))) {
        frames.push_back({audience.bus, form, request});
        all.insert(all.end(), receivers.begin(), receivers.end());
      }
    }
  }
  if (frames.empty()) {
    return ExceptionCode::illegal_data_address;
  }
  for (const Device* device : all) {
    if (const auto code = objection(*device, request)) {
      return *code;
    }
  }
  if (!understand_alike(all, request)) {
    return ExceptionCode::illegal_data_value;
  }
  if (all.empty() || !resolved.route.word_order) {
    return frames;
  }
  const auto ordered = in_order_of(*all.front(), *resolved.route.word_order, request);
  const bool alike = ordered && std::ranges::all_of(all, [&](const Device* device) {
                       const auto other = in_order_of(*device, *resolved.route.word_order, request);
                       return other && other->pdu() == ordered->pdu();
                     });
  if (!alike) {
    return ExceptionCode::illegal_data_value;
  }
  for (BroadcastFrame& frame : frames) {
    frame.request = *ordered;
  }
  return frames;
}

}  // namespace mbgate::routing
