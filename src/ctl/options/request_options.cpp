// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/request_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "config/toml/words.hpp"
#include "ctl/request/value_text.hpp"

namespace mbgate::ctl {
namespace {

constexpr std::chrono::milliseconds kShortestPeriod{10};
constexpr unsigned kMostTimes = 1'000'000'000;

std::vector<std::string> type_words() {
  std::vector<std::string> words;
  words.reserve(std::size(kTypeWords));
  for (const auto& known : kTypeWords) {
    words.emplace_back(known.word);
  }
  return words;
}

// What a word means that CLI11 has let through.
Table table_of(std::string_view word) {
  return std::ranges::find(config::kTables, word, [](const auto& it) { return it.text; })->value;
}

ValueType type_of(std::string_view word) {
  return std::ranges::find(kTypeWords, word, &TypeWord::word)->type;
}

}  // namespace

void PlaceOptions::add_to(CLI::App& command, const std::vector<std::string>& tables) {
  std::string list;
  for (const auto& table : tables) {
    list.append(list.empty() ? "" : &table == &tables.back() ? " or " : ", ").append(table);
  }
  command.add_option("table", table_, list)->required()->check(CLI::IsMember(tables));
  command.add_option("address", address_, "protocol address, counted from 0: 30 or 0x1E")
      ->required();
  command
      .add_option("--type", type_,
                  "of registers: u16 (default), i16, u32, i32, f32, u64, i64, f64 or string")
      ->check(CLI::IsMember(type_words()));
  command
      .add_option("--order", order_,
                  "of the registers of a value of 32 or 64 bits: big (high word first) or little")
      ->check(CLI::IsMember(std::vector<std::string>{"big", "little"}))
      ->capture_default_str();
  command.add_option("--unit", unit_, "unit identifier")
      ->check(CLI::Range(0, 255))
      ->capture_default_str();
  server_.add_to(command);
  server_.add_tls_to(command);
}

Result<Place, std::string> PlaceOptions::place() const {
  Place place;
  place.table = table_of(table_);
  place.order = order_ == "big" ? drive::WordOrder::big : drive::WordOrder::little;
  const bool bits = place.table == Table::coils || place.table == Table::discrete_inputs;
  if (bits && !type_.empty()) {
    return "--type is for registers: " + table_ + " hold bits";
  }
  if (bits) {
    place.type = ValueType::bit;
  } else if (!type_.empty()) {
    place.type = type_of(type_);
  }
  if (place.type == ValueType::text && place.order != drive::WordOrder::big) {
    return "--order is for numbers: the registers of a string are always in the order of its text";
  }
  const auto address = parse_address(address_);
  if (!address) {
    return address.error();
  }
  place.address = *address;
  return place;
}

Result<Target, std::string> PlaceOptions::target() const {
  auto target = server_.target();
  if (target) {
    target->unit = static_cast<std::uint8_t>(unit_);
  }
  return target;
}

ReadOptions::ReadOptions(CLI::App& app)
    : read_(app.add_subcommand("read", "Read coils, discrete inputs or registers.")) {
  where_.add_to(*read_, {"coils", "discrete", "holding", "input"});
  read_->add_option("--count", words_.count, "how many values; of a string, how many registers")
      ->capture_default_str();
  auto* every = read_->add_option(
      "--every", every_, "read again and again, from start to start: 500ms; until interrupted");
  read_->add_option("--times", words_.times, "with --every: how often")
      ->needs(every)
      ->check(CLI::Range(1U, kMostTimes));
  read_->add_flag("--quiet", words_.quiet, "print the plain values only, one a line");
  read_->add_flag("--json", words_.json, "for programs: one JSON object a read");
}

bool ReadOptions::given() const { return read_->parsed(); }

Result<Command, std::string> ReadOptions::command() const {
  const auto target = where_.target();
  if (!target) {
    return target.error();
  }
  const auto place = where_.place();
  if (!place) {
    return place.error();
  }
  ReadCommand read = words_;
  read.target = *target;
  read.place = *place;
  if (every_) {
    const auto every = parse_time(*every_, kShortestPeriod);
    if (!every) {
      return every.error();
    }
    read.every = *every;
  }
  return Command(read);
}

WriteOptions::WriteOptions(CLI::App& app)
    : write_(app.add_subcommand("write", "Write coils or holding registers.")) {
  where_.add_to(*write_, {"coils", "holding"});
  // On its own: a list of values would lose the brackets of the string "[off]".
  write_
      ->add_option("value", first_value_,
                   "decimal, or hex as the bits that go out (0xFFFE is -2 as i16); coils: 0, 1, "
                   "off or on; a string: its text")
      ->required();
  write_->add_option("more", more_values_, "values for the addresses that follow");
  write_->add_flag("--multiple", words_.multiple,
                   "use functions 15 and 16 even for one coil or register");
  write_->add_flag("--quiet", words_.quiet, "print nothing on success");
  write_->add_flag("--json", words_.json, "for programs: one JSON object");
}

bool WriteOptions::given() const { return write_->parsed(); }

Result<Command, std::string> WriteOptions::command() const {
  const auto target = where_.target();
  if (!target) {
    return target.error();
  }
  const auto place = where_.place();
  if (!place) {
    return place.error();
  }
  std::vector<std::string> words{first_value_};
  words.insert(words.end(), more_values_.begin(), more_values_.end());
  auto values = parse_values(place->type, words);
  if (!values) {
    return values.error();
  }
  WriteCommand write = words_;
  write.target = *target;
  write.place = *place;
  write.values = *std::move(values);
  return Command(write);
}

}  // namespace mbgate::ctl
