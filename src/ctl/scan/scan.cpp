// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/scan.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <ranges>
#include <set>

#include "base/text.hpp"

namespace mbgate::ctl {
namespace {

constexpr unsigned kLastUnit = 254;  // as a [[device]]
/// A busy gateway or device is asked so often.
constexpr int kTries = 3;
/// Each silence costs the bus a timeout and its repetitions.
constexpr int kMostSilent = 3;

Result<Answer, std::string> ask_patiently(const AskUnit& ask, std::uint8_t unit,
                                          const modbus::TableRange& read) {
  auto answer = ask(unit, read);
  for (int i = 1; i < kTries && answer && answer->kind == AnswerKind::busy; ++i) {
    answer = ask(unit, read);
  }
  return answer;
}

/// False when the scan must end.
bool scan_unit(std::uint8_t unit, const Catalogue& catalogue, const AskUnit& ask,
               ScanResult& result) {
  Identifier identifier(catalogue);
  FoundUnit found{unit, {}, std::chrono::nanoseconds(0)};
  int silent = 0;
  bool present = false;
  while (!found.fell_silent) {
    const auto read = identifier.next();
    if (!read) {
      break;
    }
    auto answer = ask_patiently(ask, unit, *read);
    if (!answer) {
      result.error = answer.error();
      return false;
    }
    result.any_way = result.any_way || answer->kind != AnswerKind::no_way;
    const bool of_device =
        answer->kind == AnswerKind::data || answer->kind == AnswerKind::exception;
    if (!present && !of_device) {
      if (answer->kind == AnswerKind::busy) {
        result.busy.push_back(unit);
      }
      return true;  // nobody there
    }
    present = true;
    silent += of_device ? 0 : 1;
    found.fell_silent = silent == kMostSilent;
    found.slowest = std::max(found.slowest, of_device ? answer->took : found.slowest);
    identifier.take(*read, *std::move(answer));
  }
  if (present) {
    found.identification = identifier.result();
    result.found.push_back(std::move(found));
  }
  return true;
}

std::optional<unsigned> parse_unit(std::string_view text) {
  const auto unit = integer_in<unsigned>(text);
  return unit >= 1U && unit <= unsigned{kLastUnit} ? unit : std::nullopt;
}

bool add_range(std::string_view text, std::set<std::uint8_t>& units) {
  const auto dash = text.find('-');
  const auto first = parse_unit(text.substr(0, dash));
  const auto last = dash == std::string_view::npos ? first : parse_unit(text.substr(dash + 1));
  if (!first || !last || *first > *last) {
    return false;
  }
  for (unsigned unit = *first; unit <= *last; ++unit) {
    units.insert(static_cast<std::uint8_t>(unit));
  }
  return true;
}

AnswerKind kind_of_exception(std::uint8_t code) {
  switch (static_cast<modbus::ExceptionCode>(code)) {
    case modbus::ExceptionCode::acknowledge:
    case modbus::ExceptionCode::server_device_busy: return AnswerKind::busy;
    case modbus::ExceptionCode::gateway_path_unavailable: return AnswerKind::no_way;
    case modbus::ExceptionCode::gateway_target_failed_to_respond: return AnswerKind::silence;
    default: return AnswerKind::exception;
  }
}

}  // namespace

ScanResult scan_units(const std::vector<std::uint8_t>& units, const Catalogue& catalogue,
                      const AskUnit& ask, const Progress& progress) {
  ScanResult result;
  for (const auto unit : units) {
    progress(unit, result.found.size());
    if (!scan_unit(unit, catalogue, ask, result)) {
      break;
    }
  }
  return result;
}

Result<std::vector<std::uint8_t>, std::string> parse_units(std::string_view text) {
  std::set<std::uint8_t> units;
  const bool is_list = std::ranges::all_of(std::views::split(text, ','), [&](const auto& part) {
    return add_range({part.begin(), part.end()}, units);
  });
  if (!is_list || units.empty()) {
    return fmt::format("\"{}\" is not a list of units: 1 to 254, like 5 or 1-32 or 1-8,17", text);
  }
  return std::vector<std::uint8_t>(units.begin(), units.end());
}

Answer answer_of(const modbus::TableRange& read, const modbus::Pdu& response) {
  Answer answer;
  if (response.is_exception()) {
    answer.exception = response.bytes()[1];
    answer.kind = kind_of_exception(answer.exception);
    return answer;
  }
  answer.kind = AnswerKind::data;
  ReadCommand command;
  command.place = {read.table, read.first,
                   modbus::holds_bits(read.table) ? ValueType::bit : ValueType::u16};
  command.count = read.count;
  for (const auto value : response_values(command, response)) {
    answer.registers.push_back(static_cast<std::uint16_t>(value));
  }
  return answer;
}

}  // namespace mbgate::ctl
