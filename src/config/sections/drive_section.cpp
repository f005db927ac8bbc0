// SPDX-License-Identifier: Apache-2.0
// What kind of drive a device is, and what its user states for it.
#include "config/profiles/profile_entries.hpp"
#include "config/sections/sections.hpp"
#include "config/toml/words.hpp"

namespace mbgate::config {
namespace {

/// The profile that the device names; nullptr if it names none or a wrong one.
const ProfileFile* read_profile(Draft& draft, TomlTable& table, drive::Device& device) {
  const auto name = table.string("profile");
  draft.profile_known.push_back(!table.has("profile"));
  if (!name) {
    return nullptr;
  }
  if (!draft.library.knows(*name)) {
    table.error("profile", unknown_profile(draft.library, *name));
    return nullptr;
  }
  const auto* file = draft.library.find(*name);
  if (file != nullptr) {
    draft.profile_known.back() = true;
    device.profile = file->profile;
    device.timing.response_wait = file->profile.response_wait;
    const bool stated = index(device.bus) < draft.buses.size() &&
                        draft.buses[index(device.bus)].has("response_timeout");
    if (!stated) {  // what its user says of the line, the profile cannot know
      assign(device.timing.response_timeout, file->profile.response_timeout);
    }
  }
  return file;
}

void read_orders(Draft& draft, TomlTable& table, drive::Device& device) {
  const auto& profile = device.profile;
  const bool known = draft.profile_known.back();
  const auto order = table.word<drive::WordOrder>("word_order", kWordOrders);
  if (order && profile.word_order && *order != *profile.word_order) {
    table.error("word_order", in_quotes(profile.name) + " drives have " +
                                  in_quotes(order_word(*profile.word_order)) +
                                  ", and it cannot be set");
  }
  device.word_order = order ? order : profile.word_order;
  device.opcode_order = table.word<drive::WordOrder>("opcode_order", kWordOrders);
  if (device.opcode_order && known && !profile.position_opcodes) {
    table.error("opcode_order", in_quotes(profile.name) + " has no opcodes that carry a position");
  }
  if (!device.verify_word_order || !known) {
    return;
  }
  if (!profile.word_order_register) {
    table.error("verify_word_order",
                in_quotes(profile.name) + " names no register that tells the word order");
  } else if (!table.has("word_order")) {
    table.error("verify_word_order", "needs 'word_order': what should be found there");
  }
}

constexpr std::array kEchoes = {Word{"value", false}, Word{"address", true}};

void read_writing(Draft& draft, TomlTable& table, drive::Device& device) {
  assign(device.limits_values, table.word<bool>("write_echo", kEchoes));
  const auto& profile = device.profile;
  const auto function = read_write_function(table);
  if (function && draft.profile_known.back() && !profile.functions.test(*function)) {
    table.error("write_function",
                in_quotes(profile.name) + " has no function " + std::to_string(*function));
  }
  if (function == 6 && profile.position_opcodes) {
    table.error("write_function",
                in_quotes(profile.name) +
                    " carries an opcode out as soon as it is written: a run of 06 would write its "
                    "parameters too late");
  }
  device.write_function = function;  // a maker's preference alone changes no request
  if (device.split_values && device.write_function != 6) {
    table.warning("split_values", "does nothing without write_function = 6");
  }
}

}  // namespace

void read_drive(Draft& draft, TomlTable& table, drive::Device& device) {
  const auto* file = read_profile(draft, table, device);
  read_keys(table, device_keys(), device);
  read_orders(draft, table, device);
  read_writing(draft, table, device);
  read_own_values(table, file, device);
  read_own_stops(table, device);
}

}  // namespace mbgate::config
