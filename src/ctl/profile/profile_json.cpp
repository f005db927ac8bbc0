// SPDX-License-Identifier: Apache-2.0
#include <boost/json.hpp>
#include <ranges>
#include <utility>

#include "config/profiles/profile_entries.hpp"
#include "config/toml/match_entry.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/profile/profile_text.hpp"

namespace mbgate::ctl {
namespace {

namespace json = boost::json;
using config::ProfileFile;
using config::Source;
using drive::TableRange;
using modbus::Table;

/// An array of what `one` makes of each element.
template <typename List, typename One>
json::array array_of(const List& list, One one) {
  json::array array;
  for (const auto& element : list) {
    array.emplace_back(one(element));
  }
  return array;
}

json::object with_source(json::object object, const Source& source) {
  object["name"] = source.name;
  object["line"] = json::value_from(source.line);
  if (!source.note.empty()) {
    object["note"] = source.note;
  }
  return object;
}

json::object range_json(const ProfileFile& file, const TableRange& range) {
  return {{"table", config::table_word(range.table)},
          {"first", range.first},
          {"registers", range.count},
          {"number", file.number(range.table, range.first)}};
}

json::array ranges_json(const ProfileFile& file, const config::DocumentedRanges& ranges) {
  return array_of(ranges, [&](const auto& documented) {
    return with_source(range_json(file, documented.fact), documented.source);
  });
}

json::object match_json(const drive::WriteMatch& match) {
  return {{"table", config::table_word(match.table)},
          {"address", match.address},
          {"mask", match.mask},
          {match.other ? "not" : "value", match.value}};
}

/// First addresses by table.
template <typename Ranges>
json::object firsts(Ranges ranges) {
  json::object by_table;
  for (const auto table : {Table::holding_registers, Table::input_registers}) {
    json::array list;
    for (const TableRange& range : ranges) {
      if (range.table == table) {
        list.emplace_back(range.first);
      }
    }
    by_table[config::table_word(table)] = std::move(list);
  }
  return by_table;
}

json::object firsts(const drive::ValueSet& values, unsigned registers) {
  return firsts(values.all() |
                std::views::filter([=](const auto& it) { return it.registers == registers; }) |
                std::views::transform(&drive::Value::range));
}

json::object limits_json(const drive::Limits& limits) {
  return {{"read_coils", limits.read_from(Table::coils)},
          {"read_discrete", limits.read_from(Table::discrete_inputs)},
          {"read_holding", limits.read_from(Table::holding_registers)},
          {"read_input", limits.read_from(Table::input_registers)},
          {"write_coils", limits.write_coils},
          {"write_registers", limits.write_registers}};
}

json::value order_json(const drive::Profile& profile) {
  if (profile.word_order_settable) {
    return "settable";
  }
  return profile.word_order ? json::value(config::order_word(*profile.word_order)) : nullptr;
}

json::object broadcast_json(const ProfileFile& file) {
  const auto& broadcast = file.profile.broadcast;
  const auto form = broadcast.form;
  json::object object{{"form", !form                 ? "none"
                               : form->is_standard() ? "standard"
                                                     : "own"},
                      {"most_registers", json::value_from(broadcast.most_registers)}};
  object["allowed"] = broadcast.allowed ? json::value(ranges_json(file, file.broadcast_allowed))
                                        : json::value(nullptr);
  return object;
}

void add_writes(json::object& object, const ProfileFile& file) {
  object["stops"] = array_of(file.stops, [](const auto& stop) {
    auto match = match_json(stop.fact);
    match["parameters"] = stop.fact.parameters;
    return with_source(std::move(match), stop.source);
  });
  object["no_answer"] = array_of(file.unanswered, [](const auto& unanswered) {
    auto match = match_json(unanswered.fact.match);
    match["after"] = config::to_text(unanswered.fact.after);
    return with_source(std::move(match), unanswered.source);
  });
  object["slow"] = array_of(file.slow, [&](const auto& slow) {
    auto range = range_json(file, slow.fact.range);
    range["response_timeout"] = config::to_text(slow.fact.response_timeout);
    return with_source(std::move(range), slow.source);
  });
}

void add_registers_of_order(json::object& object, const drive::Profile& profile) {
  if (const auto& place = profile.word_order_register) {
    object["word_order_register"] = {{"address", place->address},
                                     {"big", json::value_from(place->big)},
                                     {"little", json::value_from(place->little)}};
  }
  if (const auto& opcodes = profile.position_opcodes) {
    object["position_opcodes"] = {{"address", opcodes->address},
                                  {"opcodes", json::value_from(opcodes->opcodes)},
                                  {"position", opcodes->position}};
  }
}

json::object entries_json(const ProfileFile& file) {
  const auto values = array_of(file.values, [&](const config::ProfileValue& value) {
    auto object = range_json(file, value.value.range());
    object["access"] = config::word_for(config::kAccesses, value.access);
    object["motion"] = value.value.motion;
    return with_source(std::move(object), value.source);
  });
  return {{"values", values},
          {"strings", ranges_json(file, file.strings)},
          {"read_only", ranges_json(file, file.read_only)},
          {"write_only", ranges_json(file, file.write_only)},
          {"map", ranges_json(file, file.map)}};
}

}  // namespace

std::string profile_json(const config::ProfileFile& file) {
  const auto& profile = file.profile;
  json::object object{
      {"name", profile.name},
      {"description", file.description},
      {"manual", file.manual},
      {"section", file.section},
      {"lines", file.lines},
      {"file", file.path},
      {"addresses", {{"first", profile.first_address}, {"last", profile.last_address}}},
      {"functions", json::value_from(codes_in(profile.functions))},
      {"acceptances", json::value_from(codes_in(profile.acceptances))},
      {"limits", limits_json(profile.limits)},
      {"word_order", order_json(profile)},
      {"response_timeout", profile.response_timeout
                               ? json::value(config::to_text(*profile.response_timeout))
                               : nullptr},
      {"response_wait", config::to_text(profile.response_wait)},
      {"write_function", json::value_from(profile.write_function)},
      {"input_as_holding", profile.input_as_holding},
      {"broadcast", broadcast_json(file)},
      {"values32", firsts(profile.values, 2)},
      {"values64", firsts(profile.values, 4)},
      {"strings",
       firsts(file.strings | std::views::transform(&config::Documented<TableRange>::fact))}};
  add_writes(object, file);
  object["communication"] = ranges_json(file, file.communication);
  object["guarded"] = array_of(file.guarded, [&](const auto& guarded) {
    auto range = range_json(file, guarded.fact.range);
    range["mask"] = guarded.fact.mask;
    range[guarded.fact.other ? "not" : "value"] = guarded.fact.value;
    return with_source(std::move(range), guarded.source);
  });
  object["groups"] = ranges_json(file, file.groups);
  add_registers_of_order(object, profile);
  object["entries"] = entries_json(file);
  return json::serialize(object);
}

std::string profiles_json(const std::vector<const ProfileFile*>& files) {
  return json::serialize(array_of(files, [](const ProfileFile* file) {
    return json::object{{"name", file->profile.name}, {"description", file->description}};
  }));
}

}  // namespace mbgate::ctl
