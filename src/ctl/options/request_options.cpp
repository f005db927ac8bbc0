// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "config/toml/match_entry.hpp"
#include "ctl/options/subcommands.hpp"
#include "ctl/request/value_text.hpp"

namespace mbgate::ctl {
namespace {

constexpr std::chrono::milliseconds kShortestPeriod{10};
constexpr unsigned kMostTimes = 1'000'000'000;

/// What read and write both have: where the values are, of what type, and the server.
struct PlaceWords {
  std::string table;
  std::string address;
  std::string type;
  std::string order = "big";
  unsigned unit = 1;
  ServerWords server;
};

struct ReadWords {
  PlaceWords where;
  ReadCommand command;
  std::optional<std::string> every;
};

struct WriteWords {
  PlaceWords where;
  WriteCommand command;
  std::string first;
  std::vector<std::string> more;
};

std::vector<std::string> type_words() {
  std::vector<std::string> words;
  words.reserve(std::size(kTypeWords));
  for (const auto& known : kTypeWords) {
    words.emplace_back(known.word);
  }
  return words;
}

/// `tables`: the words for those that may be named.
void add_place(CLI::App& command, PlaceWords& words, const std::vector<std::string>& tables) {
  std::string list;
  for (const auto& table : tables) {
    list.append(list.empty() ? "" : &table == &tables.back() ? " or " : ", ").append(table);
  }
  command.add_option("table", words.table, list)->required()->check(CLI::IsMember(tables));
  command.add_option("address", words.address, "protocol address, counted from 0: 30 or 0x1E")
      ->required();
  command
      .add_option("--type", words.type,
                  "of registers: u16 (default), i16, u32, i32, f32, u64, i64, f64 or string")
      ->check(CLI::IsMember(type_words()));
  command
      .add_option("--order", words.order,
                  "of the registers of a value of 32 or 64 bits: big (high word first) or little")
      ->check(CLI::IsMember(std::vector<std::string>{"big", "little"}));
  command.add_option("--unit", words.unit, "unit identifier")->check(CLI::Range(0, 255));
  add_server(command, words.server);
  add_tls(command, words.server);
}

// What words mean that CLI11 has let through.
Place place_of(const PlaceWords& words) {
  Place place;
  place.table = *config::value_of(config::kTables, words.table);
  place.order = *config::value_of(config::kWordOrders, words.order);
  const bool bits = modbus::holds_bits(place.table);
  if (bits && !words.type.empty()) {
    throw WrongUsage("--type is for registers: " + words.table + " hold bits");
  }
  if (bits) {
    place.type = ValueType::bit;
  } else if (!words.type.empty()) {
    place.type = std::ranges::find(kTypeWords, std::string_view(words.type), &TypeWord::word)->type;
  }
  if (place.type == ValueType::text && place.order != drive::WordOrder::big) {
    throw WrongUsage(
        "--order is for numbers: the registers of a string are always in the order of its text");
  }
  place.address = expect(parse_address(words.address));
  return place;
}

Target target_of(const PlaceWords& words) {
  auto target = target_of(words.server);
  target.unit = static_cast<std::uint8_t>(words.unit);
  return target;
}

}  // namespace

void add_read(CLI::App& app, const Choose& choose) {
  auto* read = app.add_subcommand("read", "Read coils, discrete inputs or registers.");
  const auto words = std::make_shared<ReadWords>();
  ReadCommand& command = words->command;
  add_place(*read, words->where, {"coils", "discrete", "holding", "input"});
  read->add_option("--count", command.count, "how many values; of a string, how many registers")
      ->check(CLI::Range(1, 65536));
  auto* every =
      read->add_option("--every", words->every,
                       "repeat the read at this interval, such as 500ms, until interrupted");
  read->add_option("--times", command.times, "with --every: how often")
      ->needs(every)
      ->check(CLI::Range(1U, kMostTimes));
  read->add_flag("--quiet", command.quiet, "print the plain values only, one a line");
  read->add_flag("--json", command.json, "for programs: one JSON object a read");
  read->callback([words, choose] {
    words->command.target = target_of(words->where);
    words->command.place = place_of(words->where);
    if (words->every) {
      words->command.every = parse_time(*words->every, kShortestPeriod);
    }
    choose(words->command);
  });
}

void add_write(CLI::App& app, const Choose& choose) {
  auto* write = app.add_subcommand("write", "Write coils or holding registers.");
  const auto words = std::make_shared<WriteWords>();
  WriteCommand& command = words->command;
  add_place(*write, words->where, {"coils", "holding"});
  // On its own: a list of values would lose the brackets of the string "[off]".
  write
      ->add_option("value", words->first,
                   "decimal, or hex as the bits that go out (0xFFFE is -2 as i16); coils: 0, 1, "
                   "off or on; a string: its text")
      ->required();
  write->add_option("more", words->more, "values for the addresses that follow")->default_str("");
  write->add_flag("--multiple", command.multiple,
                  "use functions 15 and 16 even for one coil or register");
  write->add_flag("--quiet", command.quiet, "print nothing on success");
  write->add_flag("--json", command.json, "for programs: one JSON object");
  write->callback([words, choose] {
    words->command.target = target_of(words->where);
    words->command.place = place_of(words->where);
    std::vector<std::string> values{words->first};
    values.insert(values.end(), words->more.begin(), words->more.end());
    words->command.values = expect(parse_values(words->command.place.type, values));
    choose(words->command);
  });
}

}  // namespace mbgate::ctl
