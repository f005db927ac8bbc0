// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/scan.hpp"

#include <fmt/core.h>
#include <set>

#include "base/text.hpp"

namespace mbgate::ctl {
namespace {

constexpr unsigned kLastUnit = 247;  // Serial Line V1.02, 2.2
/// A busy gateway or device is asked so often.
constexpr int kTries = 3;
/// Each silence costs the bus a timeout and its repetitions.
constexpr int kMostSilent = 3;

class UnitScan {
 public:
  UnitScan(std::uint8_t unit, const Catalogue& catalogue, const AskUnit& ask)
      : unit_(unit), ask_(ask), identifier_(catalogue) {}

  /// False when the scan must end.
  bool run(ScanResult& result) {
    bool present = false;
    while (const auto read = identifier_.next()) {
      auto answer = ask_patiently(*read);
      if (!answer) {
        result.error = answer.error();
        return false;
      }
      result.any_way = result.any_way || answer->kind != AnswerKind::no_way;
      if (!present && answer->kind == AnswerKind::busy) {
        result.busy.push_back(unit_);
        return true;
      }
      if (!present && !is_of_device(*answer)) {
        return true;  // nobody there
      }
      present = true;
      take(*read, *std::move(answer));
      if (silent_ == kMostSilent) {
        break;
      }
    }
    if (present) {
      result.found.push_back({unit_, identifier_.result(), slowest_, silent_ == kMostSilent});
    }
    return true;
  }

 private:
  static bool is_of_device(const Answer& answer) {
    return answer.kind == AnswerKind::data || answer.kind == AnswerKind::exception;
  }

  Result<Answer, std::string> ask_patiently(const modbus::TableRange& read) {
    auto answer = ask_(unit_, read);
    for (int i = 1; i < kTries && answer && answer->kind == AnswerKind::busy; ++i) {
      answer = ask_(unit_, read);
    }
    return answer;
  }

  void take(const modbus::TableRange& read, Answer answer) {
    if (is_of_device(answer)) {
      slowest_ = std::max(slowest_, answer.took);
    } else {
      ++silent_;
    }
    identifier_.take(read, std::move(answer));
  }

  std::uint8_t unit_;
  const AskUnit& ask_;
  Identifier identifier_;
  std::chrono::nanoseconds slowest_{0};
  int silent_ = 0;
};

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
    if (!UnitScan(unit, catalogue, ask).run(result)) {
      break;
    }
  }
  return result;
}

Result<std::vector<std::uint8_t>, std::string> parse_units(std::string_view text) {
  std::set<std::uint8_t> units;
  std::string_view rest = text;
  while (true) {
    const auto comma = rest.find(',');
    if (!add_range(rest.substr(0, comma), units)) {
      return fmt::format("\"{}\" is not a list of units: 1 to 247, like 5 or 1-32 or 1-8,17", text);
    }
    if (comma == std::string_view::npos) {
      return std::vector<std::uint8_t>(units.begin(), units.end());
    }
    rest.remove_prefix(comma + 1);
  }
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
