// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/candidate.hpp"

#include <algorithm>
#include <array>
#include <ranges>
#include <tuple>

namespace mbgate::ctl {
namespace {

using modbus::Table;
using modbus::TableRange;

constexpr std::array kTables{Table::coils, Table::discrete_inputs, Table::holding_registers,
                             Table::input_registers};
constexpr std::uint8_t kIllegalFunction = 0x01;
/// What fits one request of any drive; 2000 bits would only load the line.
constexpr std::uint16_t kMostAsked = 125;

drive::RangeList merged(const config::DocumentedRanges& ranges) {
  drive::RangeList list;
  for (const auto& range : ranges) {
    list.push_back(range.fact);
  }
  std::ranges::sort(list, {}, [](const TableRange& it) { return std::tuple(it.table, it.first); });
  drive::RangeList result;
  for (const auto& range : list) {
    // A range of all 65536 addresses cannot be named, so a sum that is too large stays apart.
    const bool joins = !result.empty() && result.back().table == range.table &&
                       drive::end_of(result.back()) == range.first &&
                       std::uint32_t{result.back().count} + range.count <= 0xFFFFU;
    if (joins) {
      result.back().count = static_cast<std::uint16_t>(result.back().count + range.count);
    } else {
      result.push_back(range);
    }
  }
  return result;
}

TableRange one(Table table, std::uint32_t address) {
  return {table, static_cast<std::uint16_t>(address), 1};
}

void add_end(const TableRange& run, std::vector<TableRange>& reads) {
  reads.push_back(one(run.table, drive::end_of(run) - 1));
  if (drive::end_of(run) <= 0xFFFFU) {
    reads.push_back(one(run.table, drive::end_of(run)));
  }
}

bool is_printable(char letter) { return letter >= ' ' && letter <= '~'; }

Verdict judge_text(const Answer& answer, drive::WordOrder order) {
  const bool empty = std::ranges::all_of(answer.registers, [](auto it) { return it == 0; });
  if (empty) {
    return Verdict::open;  // a drive may leave its name empty
  }
  return register_text(answer.registers, order).empty() ? Verdict::contradicts : Verdict::fits;
}

Verdict judge_exception(Foreseen foreseen, std::uint8_t code) {
  const bool of_function = code == kIllegalFunction;
  switch (foreseen) {
    // Some drives refuse a function that they do not have by the address.
    case Foreseen::no_function: return of_function ? Verdict::fits : Verdict::open;
    case Foreseen::refusal: return of_function ? Verdict::contradicts : Verdict::fits;
    default: return Verdict::contradicts;
  }
}

}  // namespace

Candidate::Candidate(const config::ProfileFile& file) : file_(&file), map_(merged(file.map)) {}

Foreseen Candidate::foresees(const TableRange& read) const {
  const auto& profile = file_->profile;
  if (!says_anything()) {
    return Foreseen::anything;
  }
  if (!profile.functions.test(read_function(read.table))) {
    return Foreseen::no_function;
  }
  const TableRange range{profile.described_in(read.table), read.first, read.count};
  const auto of_table = [&](const TableRange& it) { return it.table == range.table; };
  if (std::ranges::none_of(map_, of_table)) {
    return Foreseen::anything;
  }
  if (read.count > profile.limits.read_from(read.table) ||
      drive::touches(profile.write_only, range)) {
    return Foreseen::refusal;
  }
  if (drive::covers(map_, range)) {
    const bool crosses = drive::end_of(range) > profile.group_end(range.table, range.first);
    return crosses ? Foreseen::refusal : content(range);
  }
  // What a group of parameters holds in reserve may answer or not.
  return drive::touches(profile.groups, range) ? Foreseen::anything : Foreseen::refusal;
}

Foreseen Candidate::content(const TableRange& read) const {
  const auto& order = file_->profile.word_order_register;
  if (order && read == one(Table::holding_registers, order->address)) {
    return Foreseen::word_order;
  }
  const bool text =
      std::ranges::any_of(file_->strings, [&](const auto& string) { return string.fact == read; });
  return text ? Foreseen::text : Foreseen::data;
}

Verdict Candidate::judge(const TableRange& read, const Answer& answer) const {
  const auto foreseen = foresees(read);
  if (foreseen == Foreseen::anything) {
    return Verdict::open;
  }
  if (answer.kind == AnswerKind::exception) {
    return judge_exception(foreseen, answer.exception);
  }
  const bool refused = foreseen == Foreseen::no_function || foreseen == Foreseen::refusal;
  if (answer.kind != AnswerKind::data) {
    // Silence may be what a drive has for a function that it does not know.
    return answer.kind == AnswerKind::silence && !refused ? Verdict::contradicts : Verdict::open;
  }
  const auto& profile = file_->profile;
  switch (foreseen) {
    case Foreseen::text:
      return judge_text(answer, profile.word_order.value_or(drive::WordOrder::big));
    case Foreseen::word_order:
      return order_of(*profile.word_order_register, answer.registers.front())
                 ? Verdict::fits
                 : Verdict::contradicts;
    default: return refused ? Verdict::contradicts : Verdict::fits;
  }
}

std::vector<TableRange> Candidate::content_reads() const {
  std::vector<TableRange> reads;
  for (const auto& string : file_->strings) {
    reads.push_back(string.fact);
  }
  if (const auto& order = file_->profile.word_order_register) {
    reads.push_back(one(Table::holding_registers, order->address));
  }
  return reads;
}

void Candidate::add_limit_read(Table table, std::vector<TableRange>& reads) const {
  const auto most = file_->profile.limits.read_from(table);
  if (most >= kMostAsked || !file_->profile.functions.test(read_function(table))) {
    return;
  }
  const auto run = std::ranges::find_if(map_, [&](const TableRange& it) {
    return it.table == file_->profile.described_in(table) && it.count > most &&
           !drive::touches(file_->profile.write_only,
                           {it.table, it.first, static_cast<std::uint16_t>(most + 1)});
  });
  if (run != map_.end()) {
    reads.push_back({table, run->first, static_cast<std::uint16_t>(most + 1)});
  }
}

std::vector<TableRange> Candidate::telling_reads() const {
  auto reads = content_reads();
  for (const auto& run : map_) {
    reads.push_back(one(run.table, run.first));
    add_end(run, reads);
    if (file_->profile.input_as_holding && run.table == Table::holding_registers) {
      reads.push_back(one(Table::input_registers, run.first));
    }
  }
  for (const auto& range : file_->profile.write_only) {
    reads.push_back(one(range.table, range.first));
  }
  for (const auto table : kTables) {
    add_limit_read(table, reads);
  }
  return reads;
}

std::vector<TableRange> Candidate::confirming_reads() const {
  auto reads = content_reads();
  for (const auto table : kTables) {
    const auto is_of_table = [&](const TableRange& run) { return run.table == table; };
    auto runs = map_ | std::views::filter(is_of_table);
    if (const auto longest = std::ranges::max_element(runs, {}, &TableRange::count);
        longest != runs.end()) {
      add_end(*longest, reads);
    }
    add_limit_read(table, reads);
  }
  // What may be answered either way confirms nothing.
  std::erase_if(reads, [&](const auto& read) { return foresees(read) == Foreseen::anything; });
  return reads;
}

std::optional<drive::WordOrder> order_of(const drive::WordOrderRegister& codes,
                                         std::uint16_t code) {
  if (std::ranges::find(codes.big, code) != codes.big.end()) {
    return drive::WordOrder::big;
  }
  const bool little = std::ranges::find(codes.little, code) != codes.little.end();
  return little ? std::optional(drive::WordOrder::little) : std::nullopt;
}

std::string register_text(const std::vector<std::uint16_t>& registers, drive::WordOrder order) {
  std::string text;
  for (const auto word : registers) {
    const auto high = static_cast<char>(word >> 8U);
    const auto low = static_cast<char>(word & 0xFFU);
    const bool low_first = order == drive::WordOrder::little;
    text.push_back(low_first ? low : high);
    text.push_back(low_first ? high : low);
  }
  const auto first = text.find_first_not_of(std::string_view("\0 ", 2));
  if (first == std::string::npos) {
    return {};
  }
  const auto last = text.find_last_not_of(std::string_view("\0 ", 2));
  text = text.substr(first, last - first + 1);
  return std::ranges::all_of(text, is_printable) ? text : std::string();
}

Catalogue::Catalogue(const std::vector<const config::ProfileFile*>& files) {
  for (const auto* file : files) {
    if (const Candidate candidate(*file); candidate.says_anything()) {
      candidates_.push_back(candidate);
    }
  }
  for (const auto& candidate : candidates_) {
    auto& confirming = confirming_.emplace_back();
    for (const auto& read : candidate.confirming_reads()) {
      confirming.push_back(add(read));
    }
    for (const auto& read : candidate.telling_reads()) {
      add(read);
    }
  }
  // 03 first: there is no drive without it in most plants, so it is the one that finds them.
  for (const auto table :
       {Table::holding_registers, Table::input_registers, Table::coils, Table::discrete_inputs}) {
    functions_.push_back(add_function_question(table));
  }
}

std::size_t Catalogue::add(const modbus::TableRange& read) {
  const auto known = std::ranges::find(questions_, read, &Question::read);
  if (known != questions_.end()) {
    return static_cast<std::size_t>(known - questions_.begin());
  }
  Question question{read, {}};
  for (const auto& candidate : candidates_) {
    question.foreseen.push_back(candidate.foresees(read));
  }
  questions_.push_back(std::move(question));
  return questions_.size() - 1;
}

std::size_t Catalogue::add_function_question(Table table) {
  std::size_t best = add({table, 0, 1});
  const auto count = [](const Question& question) {
    return std::ranges::count(question.foreseen, Foreseen::data);
  };
  for (std::size_t i = 0; i < questions_.size(); ++i) {
    const auto& read = questions_[i].read;
    if (read.table == table && read.count == 1 && count(questions_[i]) > count(questions_[best])) {
      best = i;
    }
  }
  return best;
}

}  // namespace mbgate::ctl
