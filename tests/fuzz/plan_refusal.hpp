// SPDX-License-Identifier: Apache-2.0
// Why a well-formed request to one drive may be refused; the drives of a scene have all functions
// and no communication registers.
#pragma once

#include <utility>
#include <vector>

#include "fuzz/plan_scene.hpp"

namespace mbgate::fuzz {

inline Asked asked(const modbus::TableRange& range) {
  return {range.table, range.first, range.count};
}

inline bool is_one_memory(const Scene& scene) {
  return scene.resolved.device != nullptr && scene.device().profile.input_as_holding;
}

inline ClientView view_of(const Scene& scene, const drive::Device& device) {
  return {scene.resolved.route.windows, device.profile.values.all(), is_one_memory(scene),
          scene.is_mirrored(device)};
}

inline bool crosses_group(const drive::Device& device, const Asked& range) {
  return std::ranges::any_of(device.profile.groups, [&](const drive::TableRange& group) {
    const auto within = [&](std::uint32_t border) {
      return range.first < border && border < range.end();
    };
    return group.table == range.table && (within(group.first) || within(drive::end_of(group)));
  });
}

/// Are registers of one value on both sides of an end of the range?
inline bool cuts_value(const ClientView& view, const Asked& range) {
  for (const std::uint32_t border : {range.first, range.end()}) {
    const auto* value = view.value_at(range.table, border);
    if (value != nullptr && value->first < border) {
      return true;
    }
  }
  return false;
}

/// With the values that are cut, where all of them must be known to be exchanged.
inline Asked widened(const Scene& scene, const ClientView& view, const Asked& range) {
  std::uint32_t first = range.first;
  std::uint32_t end = range.end();
  if (scene.is_mirrored(scene.device())) {
    const auto* front = view.value_at(range.table, first);
    const auto* back = view.value_at(range.table, end - 1);
    first = front != nullptr ? front->first : first;
    end = back != nullptr ? back->end() : end;
  }
  return {range.table, first, end - first};
}

/// By the drive that the route names. `there`: what is written.
inline bool drive_refuses(const Scene& scene, const modbus::Request& request, const Asked& there) {
  const drive::Device& device = scene.device();
  const auto& limits = device.profile.limits;
  const ClientView view = view_of(scene, device);
  const bool one_request =
      !crosses_group(device, there) && there.count <= limits.written_to(there.table);
  const bool cuts = cuts_value(view, there);
  switch (request.function()) {
    case 0x06:
    case 0x16: {
      const auto* value = view.value_at(there.table, there.first);
      return value != nullptr && value->motion;
    }
    case 0x0F: return !one_request && !device.split_writes;
    case 0x10: return cuts || (device.write_function != 6 && !one_request && !device.split_writes);
    case 0x17: {
      const Asked read = widened(scene, view, *view.moved(asked(request.reads()->range)));
      return cuts || !one_request || crosses_group(device, read) ||
             read.count > limits.read_from(read.table);
    }
    default: return false;
  }
}

inline bool may_be_refused(const Scene& scene, const modbus::Request& request) {
  const auto& route = scene.resolved.route;
  const ClientView view = view_of(scene, scene.device());
  if (request.function() == 0x08 ||
      (!route.windows.empty() && !request.reads() && !request.writes())) {
    return true;
  }
  if (request.reads()) {
    const auto there = view.moved(asked(request.reads()->range));
    if (!there || (there->table != request.reads()->range.table && request.function() > 4)) {
      return true;
    }
  }
  if (!request.writes()) {
    return false;
  }
  const auto there = view.moved(asked(request.writes()->range));
  return !there || (there->table != Table::coils && there->table != Table::holding_registers) ||
         (scene.resolved.device != nullptr && drive_refuses(scene, request, *there));
}

/// Does the manual of a drive let it be reached like this?
inline bool takes(const Scene& scene, const drive::Device& device, const modbus::Request& request) {
  const auto there = view_of(scene, device).moved(asked(request.writes()->range));
  const auto& rules = device.profile.broadcast;
  const auto allows = [&](const drive::TableRange& range) {
    return range.table == there->table && range.first <= there->first &&
           there->end() <= drive::end_of(range);
  };
  return (!rules.allowed || std::ranges::any_of(*rules.allowed, allows)) &&
         (request.function() != 0x10 || !rules.most_registers ||
          there->count <= *rules.most_registers);
}

/// Those on one bus that hear the request in this form, if it goes out in it at all.
inline std::vector<const drive::Device*> hearers(const Scene& scene,
                                                 const routing::BusDevices& known,
                                                 BroadcastForm form,
                                                 const modbus::Request& request) {
  std::vector<const drive::Device*> found;
  bool any_meant = false;
  for (const drive::Device* device : known.devices) {
    const auto own = device->profile.broadcast.form;
    const bool hears = form == BroadcastForm{129, 0x80}
                           ? own == form && takes(scene, *device, request)
                           : own != BroadcastForm{129, 0x80};
    any_meant = any_meant || (hears && own == form);
    if (hears) {
      found.push_back(device);
    }
  }
  return any_meant ? found : std::vector<const drive::Device*>{};
}

/// The values in the range are the same ones, in the same order.
inline bool mean_the_same(const drive::Device& a, const drive::Device& b, const Asked& range) {
  const auto list = [&](const drive::Device& device) {
    std::vector<std::pair<std::uint16_t, std::uint8_t>> values;
    for (const drive::Value& value : device.profile.values.all()) {
      if (value.table == range.table && value.first < range.end() && range.first < value.end()) {
        values.emplace_back(value.first, value.registers);
      }
    }
    return values;
  };
  return list(a) == list(b) && (list(a).empty() || a.word_order == b.word_order);
}

inline bool broadcast_may_be_refused(const Scene& scene, const modbus::Request& request) {
  const std::uint8_t function = request.function();
  if (function != 0x05 && function != 0x06 && function != 0x0F && function != 0x10) {
    return true;
  }
  const ClientView windows(scene.resolved.route.windows, {}, false, false);
  const auto there = windows.moved(asked(request.writes()->range));
  if (!there) {
    return true;
  }
  std::vector<const drive::Device*> all;
  bool goes_out = false;
  for (const routing::BusDevices& known : scene.resolved.devices_of_buses) {
    for (const auto form : {BroadcastForm{}, BroadcastForm{129, 0x80}}) {
      if (scene.resolved.only_form.value_or(form) == form) {
        const auto some = hearers(scene, known, form, request);
        all.insert(all.end(), some.begin(), some.end());
        goes_out = goes_out || !some.empty() || (known.devices.empty() && form == BroadcastForm{});
      }
    }
  }
  return !goes_out || std::ranges::any_of(all, [&](const drive::Device* device) {
    return there->count > device->profile.limits.written_to(there->table) ||
           cuts_value(view_of(scene, *device), *there) ||
           !mean_the_same(*all.front(), *device, *there);
  });
}

}  // namespace mbgate::fuzz
