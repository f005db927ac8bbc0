// SPDX-License-Identifier: Apache-2.0
#include "config/profiles/profile_file.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <tuple>
#include <utility>

#include "config/profiles/profile_entries.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::config {
namespace {

using drive::BroadcastForm;
using namespace std::chrono_literals;

/// So that the numbers of all 65536 addresses fit 32 bits.
constexpr IntegerRange kNumbering = {0, 4'000'000'000};

enum class FormWord : std::uint8_t { standard, own, none };
constexpr std::array kForms = {Word{"standard", FormWord::standard}, Word{"own", FormWord::own},
                               Word{"none", FormWord::none}};

enum class OrderOfMaker : std::uint8_t { big, little, settable };
constexpr std::array kOrders = {Word{"big", OrderOfMaker::big},
                                Word{"little", OrderOfMaker::little},
                                Word{"settable", OrderOfMaker::settable}};

void read_texts(ProfileDraft& draft) {
  auto& file = draft.file;
  draft.root.require_all({"name", "description", "manual"});
  const auto name = draft.root.string("name");
  assign(file.profile.name, name);
  const auto stem = std::filesystem::path(draft.document.name()).stem().string();
  if (name && *name != stem) {
    draft.root.report_expected("name", *draft.root.value("name"),
                               in_quotes(stem) + ", the name of the file");
  }
  assign(file.description, draft.root.string("description"));
  assign(file.manual, draft.root.string("manual"));
  assign(file.section, draft.root.string("section"));
  assign(file.lines, draft.root.string("lines"));
}

void read_numbering(ProfileDraft& draft) {
  if (auto table = draft.root.table("numbering")) {
    for (const auto& word : kTables) {
      assign(draft.file.numbering.at(static_cast<std::size_t>(word.value)),
             table->integer(word.text, kNumbering));
    }
  }
}

void read_behaviour(ProfileDraft& draft) {
  auto& profile = draft.file.profile;
  if (const auto addresses = read_units(draft.root, "addresses", {1, modbus::kMaxDeviceAddress})) {
    profile.first_address = addresses->first;
    profile.last_address = addresses->last;
  }
  if (read_set(draft.root, "functions", "a function", profile.functions) &&
      draft.root.list("functions")->empty()) {
    draft.root.error("functions", "an empty list lets nothing through");
  }
  read_set(draft.root, "acceptances", "an exception", profile.acceptances);
  if (const auto order = draft.root.word<OrderOfMaker>("word_order", kOrders)) {
    profile.word_order_settable = *order == OrderOfMaker::settable;
    if (*order != OrderOfMaker::settable) {
      profile.word_order =
          *order == OrderOfMaker::big ? drive::WordOrder::big : drive::WordOrder::little;
    }
  }
  profile.response_timeout = draft.root.duration("response_timeout", {1ms, 1h});
  assign(profile.response_wait, draft.root.duration("response_wait", {0s, 1min}));
  assign(profile.input_as_holding, draft.root.boolean("input_as_holding"));
  profile.write_function = read_write_function(draft.root);
}

/// Application Protocol V1.1b3, 6.1 to 6.4, 6.11, 6.12: no request can be larger.
void read_limits(ProfileDraft& draft) {
  auto table = draft.root.table("limits");
  if (!table) {
    return;
  }
  auto& limits = draft.file.profile.limits;
  const auto read = [&](std::string_view key, std::uint16_t& limit) {
    assign(limit, table->integer(key, {1, limit}));
  };
  read("read_coils", limits.read[static_cast<std::size_t>(Table::coils)]);
  read("read_discrete", limits.read[static_cast<std::size_t>(Table::discrete_inputs)]);
  read("read_holding", limits.read[static_cast<std::size_t>(Table::holding_registers)]);
  read("read_input", limits.read[static_cast<std::size_t>(Table::input_registers)]);
  read("write_coils", limits.write_coils);
  read("write_registers", limits.write_registers);
}

template <typename Fact>
std::vector<Fact> facts(const std::vector<Documented<Fact>>& documented) {
  std::vector<Fact> list;
  std::ranges::transform(documented, std::back_inserter(list), &Documented<Fact>::fact);
  return list;
}

void read_broadcast(ProfileDraft& draft) {
  auto table = draft.root.table("broadcast");
  if (!table) {
    return;
  }
  auto& broadcast = draft.file.profile.broadcast;
  table->require("form");
  const auto form = table->word<FormWord>("form", kForms);
  if (form == FormWord::none) {
    broadcast.form.reset();
  }
  if (form == FormWord::own) {
    table->require("address");
    BroadcastForm& own = broadcast.form.emplace();
    own.address = static_cast<std::uint8_t>(table->integer("address", {1, 255}).value_or(1));
    own.function_or =
        static_cast<std::uint8_t>(table->integer("function_or", {0, 255}).value_or(0));
    broadcast.only = table->boolean("only").value_or(true);
  }
  if (form && form != FormWord::own) {
    table->reject({"address", "function_or", "only"}, R"(belongs to form = "own")");
  }
  if (const auto most = table->integer("most_registers", {1, 123})) {
    broadcast.most_registers = static_cast<std::uint16_t>(*most);
  }
  draft.file.broadcast_allowed = read_ranges(draft.file, table->tables("allowed"), kWritableTables);
  if (table->has("allowed")) {
    broadcast.allowed = facts(draft.file.broadcast_allowed);
  }
}

std::vector<std::uint16_t> read_codes(TomlTable& table, std::string_view key) {
  std::vector<std::uint16_t> codes;
  table.require(key);
  const auto* elements = table.list(key);
  if (elements == nullptr) {
    return codes;
  }
  for (const auto& element : *elements) {
    const auto* code = std::get_if<std::int64_t>(&element.data);
    if (code == nullptr || *code < kRegisterValues.min || *code > kRegisterValues.max) {
      table.report_expected(key, element, "an integer from 0 to 65535");
    } else {
      codes.push_back(static_cast<std::uint16_t>(*code));
    }
  }
  return codes;
}

void read_word_order_register(ProfileDraft& draft) {
  auto table = draft.root.table("word_order_register");
  if (!table) {
    return;
  }
  table->require("register");
  const auto address = read_register(draft.file, *table, "register", Table::holding_registers);
  auto big = read_codes(*table, "big");
  auto little = read_codes(*table, "little");
  draft.file.word_order_line = read_manual_line(*table);
  for (const auto code : little) {
    if (std::ranges::find(big, code) != big.end()) {
      table->error("little", "{} is used for both orders", code);
    }
  }
  if (address) {
    draft.file.profile.word_order_register = {*address, std::move(big), std::move(little)};
  }
}

void read_position_opcodes(ProfileDraft& draft) {
  auto table = draft.root.table("position_opcodes");
  if (!table) {
    return;
  }
  table->require_all({"register", "position"});
  const auto address = read_register(draft.file, *table, "register", Table::holding_registers);
  const auto position = read_register(draft.file, *table, "position", Table::holding_registers);
  auto opcodes = read_codes(*table, "opcodes");
  draft.file.position_opcodes_line = read_manual_line(*table);
  if (position == 0xFFFF) {
    table->error("position", "its second register would lie beyond the table");
  }
  if (address && position) {
    draft.file.profile.position_opcodes = {*address, std::move(opcodes), *position};
  }
}

void read_lists(ProfileDraft& draft) {
  auto& file = draft.file;
  const auto ranges = [&](std::string_view key, std::span<const Word<Table>> tables,
                          std::vector<TomlTable>* places = nullptr) {
    return read_ranges(file, draft.root.tables(key), tables, places);
  };
  file.map = ranges("map", kTables);
  file.groups = ranges("groups", kTables, &draft.group_tables);
  file.strings = ranges("strings", kRegisterTables, &draft.string_tables);
  file.read_only = ranges("read_only", kTables);
  file.write_only = ranges("write_only", kWritableTables);
  read_communication(draft);
  read_values(draft);
  read_slow(draft);
  read_unanswered(draft);
  read_stops(draft);
}

/// What check_profile() needs of the rules, out of what was documented.
void fill_rules(ProfileFile& file) {
  auto& profile = file.profile;
  profile.map = facts(file.map);
  profile.groups = facts(file.groups);
  profile.read_only = facts(file.read_only);
  profile.write_only = facts(file.write_only);
  profile.communication = facts(file.communication);
  profile.slow = facts(file.slow);
  profile.unanswered = facts(file.unanswered);
  profile.stops = facts(file.stops);
}

void fill_values(ProfileFile& file) {
  auto& profile = file.profile;
  profile.guarded = facts(file.guarded);
  std::ranges::stable_sort(file.values, [](const ProfileValue& a, const ProfileValue& b) {
    return std::tie(a.value.table, a.value.first) < std::tie(b.value.table, b.value.first);
  });
  for (const auto& [value, access, source] : file.values) {
    profile.values.add(value);
    if (access != ValueAccess::read_write) {
      (access == ValueAccess::read ? profile.read_only : profile.write_only)
          .push_back(value.range());
    }
  }
}

LoadedProfile read(TomlDocument document) {
  LoadedProfile loaded;
  if (document.parsed()) {
    ProfileDraft draft(document);
    draft.file.path = document.name();
    read_texts(draft);
    read_numbering(draft);  // before any register
    read_behaviour(draft);
    read_limits(draft);
    read_lists(draft);
    read_broadcast(draft);
    read_word_order_register(draft);
    read_position_opcodes(draft);
    fill_rules(draft.file);
    check_profile(draft);
    fill_values(draft.file);
    loaded.file = std::move(draft.file);
  }
  loaded.diagnostics = document.finish();
  if (has_errors(loaded.diagnostics)) {
    loaded.file.reset();
  }
  return loaded;
}

}  // namespace

std::string ProfileFile::number(modbus::Table table, std::uint32_t address) const {
  const auto first = numbering.at(static_cast<std::size_t>(table));
  return first != 0 ? std::to_string(first + address) : fmt::format("0x{:04X}", address);
}

LoadedProfile load_profile(const TextFile& file) { return read(TomlDocument::parse({file})); }

}  // namespace mbgate::config
