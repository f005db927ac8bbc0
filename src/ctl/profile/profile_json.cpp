// SPDX-License-Identifier: Apache-2.0
#include <boost/json.hpp>
#include <string_view>

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

json::value text(std::string_view words) { return json::string_view(words.data(), words.size()); }

json::value table_json(Table table) { return text(config::table_word(table)); }

/// An array of what `one` makes of each element.
template <typename List, typename One>
json::array array_of(const List& list, One one) {
  json::array array;
  for (const auto& element : list) {
    array.emplace_back(one(element));
  }
  return array;
}

void add_source(json::object& object, const Source& source) {
  object["name"] = text(source.name);
  object["line"] = json::value_from(source.line);
  if (!source.note.empty()) {
    object["note"] = text(source.note);
  }
}

json::object range_json(const ProfileFile& file, const TableRange& range) {
  return {{"table", table_json(range.table)},
          {"first", range.first},
          {"registers", range.count},
          {"number", text(file.number(range.table, range.first))}};
}

json::array ranges_json(const ProfileFile& file, const config::DocumentedRanges& ranges) {
  return array_of(ranges, [&](const auto& documented) {
    auto object = range_json(file, documented.fact);
    add_source(object, documented.source);
    return object;
  });
}

json::object match_json(const drive::WriteMatch& match) {
  return {{"table", table_json(match.table)},
          {"address", match.address},
          {"mask", match.mask},
          {match.other ? "not" : "value", match.value}};
}

/// First addresses by table.
json::object firsts(const drive::ValueSet& values, unsigned registers) {
  json::object by_table;
  for (const auto table : {Table::holding_registers, Table::input_registers}) {
    json::array list;
    for (const auto& value : values.all()) {
      if (value.table == table && value.registers == registers) {
        list.emplace_back(value.first);
      }
    }
    by_table[config::table_word(table)] = std::move(list);
  }
  return by_table;
}

json::object firsts(const config::DocumentedRanges& ranges) {
  json::object by_table;
  for (const auto table : {Table::holding_registers, Table::input_registers}) {
    json::array list;
    for (const auto& range : ranges) {
      if (range.fact.table == table) {
        list.emplace_back(range.fact.first);
      }
    }
    by_table[config::table_word(table)] = std::move(list);
  }
  return by_table;
}

json::object limits_json(const drive::Limits& limits) {
  return {{"read_coils", limits.read_from(Table::coils)},
          {"read_discrete", limits.read_from(Table::discrete_inputs)},
          {"read_holding", limits.read_from(Table::holding_registers)},
          {"read_input", limits.read_from(Table::input_registers)},
          {"write_coils", limits.write_coils},
          {"write_registers", limits.write_registers}};
}

template <std::size_t Size>
json::array codes_json(const std::bitset<Size>& set) {
  json::array codes;
  for (std::size_t code = 1; code < Size; ++code) {
    if (set.test(code)) {
      codes.emplace_back(code);
    }
  }
  return codes;
}

json::value order_json(const drive::Profile& profile) {
  if (profile.word_order_settable) {
    return "settable";
  }
  return profile.word_order ? text(config::order_word(*profile.word_order)) : json::value(nullptr);
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
    add_source(match, stop.source);
    return match;
  });
  object["no_answer"] = array_of(file.unanswered, [](const auto& unanswered) {
    auto match = match_json(unanswered.fact.match);
    match["after"] = text(config::to_text(unanswered.fact.after));
    add_source(match, unanswered.source);
    return match;
  });
  object["slow"] = array_of(file.slow, [&](const auto& slow) {
    auto range = range_json(file, slow.fact.range);
    range["response_timeout"] = text(config::to_text(slow.fact.response_timeout));
    add_source(range, slow.source);
    return range;
  });
}

void add_registers_of_order(json::object& object, const drive::Profile& profile) {
  const auto codes = [](const std::vector<std::uint16_t>& list) {
    return array_of(list, [](std::uint16_t code) { return json::value(code); });
  };
  if (const auto& place = profile.word_order_register) {
    object["word_order_register"] = {
        {"address", place->address}, {"big", codes(place->big)}, {"little", codes(place->little)}};
  }
  if (const auto& opcodes = profile.position_opcodes) {
    object["position_opcodes"] = {{"address", opcodes->address},
                                  {"opcodes", codes(opcodes->opcodes)},
                                  {"position", opcodes->position}};
  }
}

json::object entries_json(const ProfileFile& file) {
  const auto values = array_of(file.values, [&](const config::ProfileValue& value) {
    auto object = range_json(file, value.value.range());
    object["access"] = text(access_text(value.access));
    object["motion"] = value.value.motion;
    add_source(object, value.source);
    return object;
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
      {"name", text(profile.name)},
      {"description", text(file.description)},
      {"manual", text(file.manual)},
      {"section", text(file.section)},
      {"lines", text(file.lines)},
      {"file", text(file.path)},
      {"addresses", {{"first", profile.first_address}, {"last", profile.last_address}}},
      {"functions", codes_json(profile.functions)},
      {"acceptances", codes_json(profile.acceptances)},
      {"limits", limits_json(profile.limits)},
      {"word_order", order_json(profile)},
      {"response_timeout", profile.response_timeout
                               ? text(config::to_text(*profile.response_timeout))
                               : json::value(nullptr)},
      {"response_wait", text(config::to_text(profile.response_wait))},
      {"write_function", json::value_from(profile.write_function)},
      {"input_as_holding", profile.input_as_holding},
      {"broadcast", broadcast_json(file)},
      {"values32", firsts(profile.values, 2)},
      {"values64", firsts(profile.values, 4)},
      {"strings", firsts(file.strings)}};
  add_writes(object, file);
  object["communication"] = ranges_json(file, file.communication);
  object["guarded"] = array_of(file.guarded, [&](const auto& guarded) {
    auto range = range_json(file, guarded.fact.range);
    range["mask"] = guarded.fact.mask;
    range[guarded.fact.other ? "not" : "value"] = guarded.fact.value;
    add_source(range, guarded.source);
    return range;
  });
  object["groups"] = ranges_json(file, file.groups);
  add_registers_of_order(object, profile);
  object["entries"] = entries_json(file);
  return json::serialize(object);
}

std::string profiles_json(const std::vector<ProfileTitle>& titles) {
  return json::serialize(array_of(titles, [](const ProfileTitle& title) {
    return json::object{{"name", text(title.name)}, {"description", text(title.description)}};
  }));
}

}  // namespace mbgate::ctl
