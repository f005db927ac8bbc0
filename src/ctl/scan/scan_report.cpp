// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/scan_report.hpp"

#include <algorithm>

#include "config/profiles/profile_library.hpp"
#include "config/toml/duration_text.hpp"
#include "config/toml/words.hpp"
#include "ctl/profile/profile_text.hpp"

namespace mbgate::ctl {
namespace {

using Row = std::vector<std::string>;

std::string functions_text(const Identification& identification) {
  std::string text;
  for (std::size_t function = 1; function <= 4; ++function) {
    if (identification.functions.test(function)) {
      text.append(text.empty() ? "0" : " 0").append(std::to_string(function));
    }
  }
  return text.empty() ? "none" : text;
}

std::string sureness_text(const FoundUnit& unit) {
  const auto& found = unit.identification;
  if (found.nearest == nullptr) {
    return "-";
  }
  std::string text = std::to_string(found.fitting) + " of " + std::to_string(found.judged);
  if (found.likely.empty()) {
    text += " for " + found.nearest->profile.name;
  }
  return unit.fell_silent ? text + ", then silent" : text;
}

std::string order_text(const Identification& found) {
  if (word_order_unknown(found)) {
    return "unknown";
  }
  return found.word_order ? std::string(config::order_word(*found.word_order)) : "-";
}

std::string texts_of(const Identification& found) {
  std::string text;
  for (const auto& [name, value] : found.texts) {
    text.append(text.empty() ? "" : ", ").append(name).append(" \"").append(value).append("\"");
  }
  return text.empty() ? "-" : text;
}

Row row_of(const FoundUnit& unit) {
  const auto& found = unit.identification;
  const auto took = std::chrono::ceil<std::chrono::milliseconds>(unit.slowest);
  return {
      std::to_string(unit.unit), functions_text(found), config::to_text(took), likely_text(found),
      sureness_text(unit),       order_text(found),     texts_of(found)};
}

}  // namespace

std::string scan_table(const ScanResult& result) {
  std::vector<Row> rows{
      {"unit", "functions", "slowest", "profile", "answers that fit", "word order", "texts"}};
  bool several = false;
  bool none = false;
  for (const auto& unit : result.found) {
    rows.push_back(row_of(unit));
    several = several || unit.identification.likely.size() > 1;
    none = none || unit.identification.likely.empty();
  }
  std::string text = columns(rows);
  if (several) {
    text += "Profiles joined by \"or\" cannot be told apart by reading.\n";
  }
  if (none) {
    text += "Where the profile is generic, none fits; the nearest one is named.\n";
  }
  return text;
}

std::string line_head(const FoundLine& line) {
  return line.device + ", " + std::to_string(static_cast<std::uint32_t>(line.mode.baud)) +
         " baud, parity " + std::string(parity_word(line.mode.format.parity)) + ", stop bits " +
         std::to_string(line.mode.format.stop_bits) + ":\n";
}

std::string likely_text(const Identification& identification) {
  if (identification.likely.empty()) {
    return std::string(config::kGenericProfile);
  }
  std::string text;
  for (const auto* file : identification.likely) {
    text.append(text.empty() ? "" : " or ").append(file->profile.name);
  }
  return text;
}

bool word_order_unknown(const Identification& identification) {
  const auto& likely = identification.likely;
  return !identification.word_order && std::ranges::any_of(likely, [](const auto* it) {
    return it->profile.word_order_settable;
  });
}

}  // namespace mbgate::ctl
