// SPDX-License-Identifier: Apache-2.0
// The head of a profile's text: one line for each thing that concerns the whole drive.
#include <array>
#include <fmt/format.h>
#include <utility>

#include "base/text.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/profile/profile_text.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

using config::ProfileFile;
using config::to_text;
using modbus::Table;

constexpr std::size_t kFunctions = 127;

std::string functions_text(const ProfileFile& file) {
  const auto& functions = file.profile.functions;
  return functions.count() == kFunctions ? "all"
                                         : fmt::format("{}", fmt::join(codes_in(functions), ", "));
}

std::string order_text(const ProfileFile& file) {
  const auto& profile = file.profile;
  if (profile.word_order) {
    return *profile.word_order == drive::WordOrder::big ? "big: high word first"
                                                        : "little: low word first";
  }
  if (!profile.word_order_settable) {
    return "none";
  }
  if (!profile.word_order_register) {
    return "set at the drive";
  }
  const auto& place = *profile.word_order_register;
  return fmt::format(
      "set at the drive: {} holds {} when big, {} when little{}",
      file.number(Table::holding_registers, place.address), fmt::join(place.big, " or "),
      fmt::join(place.little, " or "),
      file.word_order_line ? fmt::format(" (line {})", line_text(file.word_order_line)) : "");
}

/// "50 holding registers", "1 input register"
std::string limit_text(std::uint16_t limit, Table table) {
  auto name = table_name(table);
  if (limit == 1) {
    name.remove_suffix(1);
  }
  return fmt::format("{} {}", limit, name);
}

std::string acceptances_text(const drive::Profile& profile) {
  return joined(codes_in(profile.acceptances), [](unsigned code) {
    return modbus::exception_text(static_cast<std::uint8_t>(code));
  });
}

/// The limits of what the drive's functions can do at all.
std::string reads_text(const ProfileFile& file) {
  constexpr std::array kReads = {std::pair(1U, Table::coils), std::pair(2U, Table::discrete_inputs),
                                 std::pair(3U, Table::holding_registers),
                                 std::pair(4U, Table::input_registers)};
  std::vector<std::string> limits;
  for (const auto& [function, table] : kReads) {
    if (file.profile.functions.test(function)) {
      limits.push_back(limit_text(file.profile.limits.read_from(table), table));
    }
  }
  return fmt::format("{}", fmt::join(limits, ", "));
}

std::string writes_text(const ProfileFile& file) {
  const auto& profile = file.profile;
  std::vector<std::string> limits;
  if (profile.functions.test(15)) {
    limits.push_back(limit_text(profile.limits.write_coils, Table::coils));
  }
  if (profile.functions.test(16)) {
    limits.push_back(limit_text(profile.limits.write_registers, Table::holding_registers));
  }
  if (profile.write_function) {
    limits.push_back(fmt::format("preferably with function {}", *profile.write_function));
  }
  return fmt::format("{}", fmt::join(limits, ", "));
}

std::string broadcast_text(const ProfileFile& file) {
  const auto& broadcast = file.profile.broadcast;
  if (!broadcast.form) {
    return "none stated";
  }
  std::string text = fmt::format("at address {}", broadcast.form->address);
  if (broadcast.form->function_or != 0) {
    text += fmt::format(", with function codes OR 0x{:02X}", broadcast.form->function_or);
  }
  if (broadcast.most_registers) {
    text += fmt::format(", at most {} registers", *broadcast.most_registers);
  }
  if (!file.broadcast_allowed.empty()) {
    text += ", only to " + joined(file.broadcast_allowed, [&](const auto& allowed) {
              return fmt::format("{} {}", table_name(allowed.fact.table),
                                 number_text(file, allowed.fact));
            });
  }
  return text;
}

}  // namespace

std::string profile_head(const config::ProfileFile& file) {
  const auto& profile = file.profile;
  std::vector<std::vector<std::string>> rows = {{"manual", file.manual}};
  if (!file.section.empty()) {
    rows.push_back({"section", file.section + (file.lines.empty() ? "" : ", lines " + file.lines)});
  }
  if (!file.path.empty()) {
    rows.push_back({"file", file.path});
  }
  rows.push_back({"addresses", fmt::format("{}-{} on a serial line", profile.first_address,
                                           profile.last_address)});
  rows.push_back({"functions", functions_text(file)});
  if (profile.acceptances.any()) {
    rows.push_back({"accepts with", acceptances_text(profile)});
  }
  rows.push_back({"reads at most", reads_text(file)});
  rows.push_back({"writes at most", writes_text(file)});
  if (profile.input_as_holding) {
    rows.push_back({"function 4", "reads the holding registers"});
  }
  rows.push_back({"word order", order_text(file)});
  if (profile.response_timeout) {
    rows.push_back({"response timeout", to_text(*profile.response_timeout)});
  }
  rows.push_back({"response wait", to_text(profile.response_wait)});
  rows.push_back({"broadcasts", broadcast_text(file)});
  return fmt::format("{}: {}\n{}", profile.name, file.description, columns(rows));
}

std::string hex(unsigned number) { return fmt::format("0x{:04X}", number); }

std::string line_text(const std::optional<std::uint32_t>& line) {
  return line ? std::to_string(*line) : "";
}

std::string number_text(const ProfileFile& file, const drive::TableRange& range) {
  const auto first = file.number(range.table, range.first);
  return range.count == 1
             ? first
             : fmt::format("{}-{}", first, file.number(range.table, drive::end_of(range) - 1));
}

}  // namespace mbgate::ctl
