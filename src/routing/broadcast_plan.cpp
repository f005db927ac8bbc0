// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>

#include "routing/device_plan.hpp"

namespace mbgate::routing {
namespace {
using drive::BroadcastForm;
using drive::Device;
using modbus::ExceptionCode;
using modbus::Request;
using modbus::TableRange;
using Receivers = std::vector<const Device*>;

// Does the manual of this drive let such a broadcast reach it?
bool takes(const Device& device, const Request& request) {
  const auto& rules = device.profile.broadcast;
  const TableRange& range = request.writes()->range;
  return device.profile.functions.test(request.function()) &&
         (!rules.allowed || drive::covers(*rules.allowed, range)) &&
         (request.function() != 0x10 || !rules.most_registers ||
          range.count <= *rules.most_registers);
}

// The standard one first, then each of its own that a profile states.
auto forms_of(const BusDevices& known) {
  boost::container::small_vector<BroadcastForm, 2> forms{BroadcastForm{}};
  for (const Device* device : known.devices) {
    const auto& form = device->profile.broadcast.form;
    if (form && std::ranges::find(forms, *form) == forms.end()) {
      forms.push_back(*form);
    }
  }
  return forms;
}

// Those that may carry the request out if it goes out in this form. At address 0 nobody can be kept
// from listening, not even a drive whose manual states no broadcasts; a form of its own is known to
// be heard for what its manual lists, and only for that.
Receivers receivers_of(const BusDevices& known, BroadcastForm form, const Request& request) {
  Receivers receivers;
  std::ranges::copy_if(known.devices, std::back_inserter(receivers), [&](const Device* device) {
    const drive::Broadcast& rules = device->profile.broadcast;
    if (!form.is_standard()) {
      return rules.form == form && takes(*device, request);
    }
    return !(rules.has_own_form() && rules.only) &&
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
  return std::ranges::equal(a.profile.values.in(range), b.profile.values.in(range), {},
                            &drive::Value::range, &drive::Value::range);
}

// What a value's words mean must be the same for all who hear them.
bool understand_alike(const Receivers& receivers, const Request& request) {
  const TableRange& range = request.writes()->range;
  if (std::ranges::none_of(receivers,
                           [&](const Device* it) { return it->writes_value(request); })) {
    return true;
  }
  const Device& first = *receivers.front();
  return std::ranges::all_of(receivers, [&](const Device* it) {
    const bool same_order =
        it->word_order == first.word_order && (it->word_order.has_value() || receivers.size() == 1);
    return same_order && same_values(first, *it, range);
  });
}

// Are the registers there, as far as the profile of this drive says?
bool has_registers(const Device& device, const Request& request) {
  const auto& map = device.profile.map;
  return takes(device, request) && (map.empty() || drive::covers(map, request.writes()->range));
}

// A frame, and who may carry it out.
struct Sent {
  drive::Transaction frame;
  Receivers receivers;
};
using AllSent = boost::container::small_vector<Sent, 2>;

// `form`: who hears this one.
Receivers everyone(const AllSent& sent, std::optional<BroadcastForm> form = std::nullopt) {
  Receivers all;
  for (const Sent& it : sent) {
    if (!form || it.frame.broadcast == form) {
      all.insert(all.end(), it.receivers.begin(), it.receivers.end());
    }
  }
  return all;
}

/// A device of these that the request stops; nullptr: there is none. Of those that may hear address
/// 0, a drive whose manual does not say so is not known to stop.
const Device* first_stopped(const AllSent& sent, const Request& request,
                            std::optional<BusId> bus = std::nullopt) {
  for (const Sent& it : sent) {
    for (const Device* device : it.receivers) {
      if ((!bus || it.frame.bus == *bus) && device->profile.broadcast.hears(*it.frame.broadcast) &&
          device->is_stop(request)) {
        return device;
      }
    }
  }
  return nullptr;
}

bool is_asked(const ResolvedRoute& resolved, const Device& device) {
  return !resolved.only_form || device.profile.broadcast.form == *resolved.only_form;
}

bool reconfigures_any(const ResolvedRoute& resolved, const Receivers& receivers,
                      const Request& request) {
  const auto& seen = resolved.route.word_order;
  return std::ranges::any_of(receivers, [&](const Device* device) {
    return !device->allow_reconfigure &&
           device->is_reconfigured_by(request, seen ? seen : device->word_order);
  });
}

// Does the register mean the same to all who hear this form? A profile says what registers mean.
bool mean_the_same(const AllSent& sent, std::optional<BroadcastForm> form) {
  const auto name_of = [](const Device* it) -> const std::string& { return it->profile.name; };
  const Receivers all = everyone(sent, form);
  return std::ranges::adjacent_find(all, std::ranges::not_equal_to(), name_of) == all.end();
}

// Has every device of these buses the registers, and with one meaning?
std::optional<ExceptionCode> misunderstanding(const ResolvedRoute& resolved, const AllSent& sent,
                                              const Request& request) {
  for (const BusDevices& known : resolved.devices_of_buses) {
    for (const Device* device : known.devices) {
      if (is_asked(resolved, *device) && !has_registers(*device, request)) {
        return ExceptionCode::illegal_data_address;
      }
    }
  }
  const bool alike = std::ranges::all_of(
      sent, [&](const Sent& it) { return mean_the_same(sent, it.frame.broadcast); });
  return alike ? std::nullopt : std::optional(ExceptionCode::illegal_data_value);
}

bool hold_it_whole(const Receivers& receivers, const Request& request) {
  const TableRange& range = request.writes()->range;
  return std::ranges::all_of(receivers, [&](const Device* device) {
    return range.count <= device->profile.limits.written_to(range.table) &&
           !device->cuts_value(range);
  });
}

// The request with its values in the order that the device speaks; nothing where that is uncertain.
std::optional<Request> in_order_of(const Device& device, drive::WordOrder seen,
                                   const Request& request) {
  if (device.has_uncertain_position(seen, request)) {
    return std::nullopt;
  }
  return request.function() == 0x10
             ? modbus::make_multiple_write(request.writes()->range,
                                           device.data_in_order(seen, request))
             : request;
}

// The request in the order of all who hear it; nothing where they do not agree, or do not hold it.
std::optional<Request> in_order_of_all(const ResolvedRoute& resolved, const Receivers& all,
                                       const Request& request) {
  if (!hold_it_whole(all, request) || !understand_alike(all, request)) {
    return std::nullopt;
  }
  const auto seen = resolved.route.word_order;
  if (all.empty() || !seen) {
    return request;
  }
  const auto ordered = in_order_of(*all.front(), *seen, request);
  const bool alike = ordered && std::ranges::all_of(all, [&](const Device* device) {
                       const auto other = in_order_of(*device, *seen, request);
                       return other && other->pdu() == ordered->pdu();
                     });
  return alike ? ordered : std::nullopt;
}

// In every form that somebody is there for; where nothing is known, in the standard one.
AllSent all_forms(const ResolvedRoute& resolved, const Request& request) {
  AllSent sent;
  for (const BusDevices& known : resolved.devices_of_buses) {
    for (const BroadcastForm form : forms_of(known)) {
      Receivers receivers = receivers_of(known, form, request);
      const bool unknown_devices = known.devices.empty() && form.is_standard();
      const bool wanted = !resolved.only_form || *resolved.only_form == form;
      if (wanted && (unknown_devices || is_meant(receivers, form))) {
        sent.push_back({{form.address, request, false, form}, std::move(receivers)});
        sent.back().frame.bus = known.bus;
      }
    }
  }
  return sent;
}

// A stop goes on each bus where it stops a device, whatever it is to others there. On other buses
// it would be a write that nobody has asked for, unless they hold it for one too.
void keep_what_stops(AllSent& sent, const Device& stopped, const Request& request) {
  const auto is_kept = [&](const Sent& one) {
    return first_stopped(sent, request, one.frame.bus) != nullptr ||
           (hold_it_whole(one.receivers, request) &&
            std::ranges::all_of(one.receivers, [&](const Device* it) {
              return it->profile.name == stopped.profile.name;
            }));
  };
  AllSent kept;
  std::ranges::copy_if(sent, std::back_inserter(kept), is_kept);
  sent = std::move(kept);
}

}  // namespace

Result<BroadcastFrames, ExceptionCode> plan_broadcast(const ResolvedRoute& resolved,
                                                      const Request& request) {
  if (!request.writes()) {  // it is planned all the same to know what was denied
    return ExceptionCode::illegal_function;
  }
  AllSent sent = all_forms(resolved, request);
  if (sent.empty()) {
    return ExceptionCode::illegal_data_address;
  }
  const Device* const stopped = first_stopped(sent, request);
  const bool is_stop = stopped != nullptr;
  if (is_stop && !resolved.route.broadcast_mixed) {
    keep_what_stops(sent, *stopped, request);
  }
  const Receivers all = everyone(sent);
  if (reconfigures_any(resolved, all, request)) {
    return ExceptionCode::illegal_function;
  }
  const auto code = is_stop || resolved.route.broadcast_mixed
                        ? std::nullopt
                        : misunderstanding(resolved, sent, request);
  if (code) {
    return *code;
  }
  auto ordered = in_order_of_all(resolved, all, request);
  if (!ordered && is_stop) {
    ordered = request;  // it is never refused for its parameters
  }
  if (!ordered) {
    return ExceptionCode::illegal_data_value;
  }
  BroadcastFrames frames;
  for (const Sent& it : sent) {
    frames.push_back(it.frame);
    frames.back().request = *ordered;
  }
  return frames;
}

std::vector<const Device*> not_addressed(const ResolvedRoute& resolved, const Plan& plan,
                                         bool is_stop) {
  std::vector<const Device*> left_out;
  const auto is_for = [&](const Device& device, const drive::Transaction& it) {
    return it.broadcast && it.bus == device.bus &&
           device.is_addressed_by(it.address, it.broadcast) &&
           (is_stop ? device.is_stop(it.request) : has_registers(device, it.request));
  };
  for (const BusDevices& known : resolved.devices_of_buses) {
    for (const Device* device : known.devices) {
      if (is_asked(resolved, *device) && std::ranges::none_of(plan.transactions(), [&](auto& it) {
            return is_for(*device, it);
          })) {
        left_out.push_back(device);
      }
    }
  }
  return left_out;
}

}  // namespace mbgate::routing
