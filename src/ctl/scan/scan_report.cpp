// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/scan_report.hpp"

#include <algorithm>
#include <boost/json.hpp>
#include <fmt/format.h>

#include "base/text.hpp"
#include "config/profiles/profile_library.hpp"
#include "config/toml/match_entry.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/profile/profile_text.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

using Row = std::vector<std::string>;

std::string functions_text(const Identification& identification) {
  const auto functions = codes_in(identification.functions);
  return functions.empty() ? "none" : fmt::format("{:02}", fmt::join(functions, " "));
}

/// "moons-m3", or "moons-ssdc or moons-stb"; "generic" if no profile fits.
std::string likely_text(const Identification& identification) {
  if (identification.likely.empty()) {
    return std::string(config::kGenericProfile);
  }
  return joined(
      identification.likely, [](const auto* file) { return file->profile.name; }, " or ");
}

std::string sureness_text(const FoundUnit& unit) {
  const auto& found = unit.identification;
  if (found.nearest == nullptr) {
    return "-";
  }
  std::string text = fmt::format("{} of {}", found.fitting, found.judged);
  if (found.likely.empty()) {
    text += " for " + found.nearest->profile.name;
  }
  return unit.fell_silent ? text + ", then silent" : text;
}

/// "big", "little" or "unknown"; nothing where none is known, and none needed.
std::optional<std::string> order_word_of(const Identification& found) {
  if (word_order_unknown(found)) {
    return "unknown";
  }
  return found.word_order ? std::optional<std::string>(config::order_word(*found.word_order))
                          : std::nullopt;
}

std::string texts_of(const Identification& found) {
  const auto text = joined(
      found.texts, [](const auto& it) { return fmt::format("{} \"{}\"", it.name, it.text); });
  return text.empty() ? "-" : text;
}

Row row_of(const FoundUnit& unit) {
  const auto& found = unit.identification;
  const auto took = std::chrono::ceil<std::chrono::milliseconds>(unit.slowest);
  return {std::to_string(unit.unit),
          functions_text(found),
          config::to_text(took),
          likely_text(found),
          sureness_text(unit),
          order_word_of(found).value_or("-"),
          texts_of(found)};
}

boost::json::array texts_json(const std::vector<NamedText>& texts) {
  boost::json::array list;
  for (const auto& [name, text] : texts) {
    list.push_back(boost::json::object{{"name", name}, {"text", text}});
  }
  return list;
}

boost::json::object unit_json(const FoundUnit& unit) {
  const auto& found = unit.identification;
  boost::json::array profiles;
  for (const auto* file : found.likely) {
    profiles.emplace_back(file->profile.name);
  }
  const boost::json::value nearest =
      found.nearest != nullptr ? boost::json::value(found.nearest->profile.name) : nullptr;
  return {{"unit", unit.unit},
          {"functions", boost::json::value_from(codes_in(found.functions))},
          {"slowest_ms", std::chrono::ceil<std::chrono::milliseconds>(unit.slowest).count()},
          {"profiles", std::move(profiles)},
          {"nearest", nearest},
          {"fitting", found.fitting},
          {"judged", found.judged},
          {"word_order", boost::json::value_from(order_word_of(found))},
          {"texts", texts_json(found.texts)},
          {"fell_silent", unit.fell_silent}};
}

boost::json::value line_json(const FoundLine& line) {
  return boost::json::object{
      {"device", line.device},
      {"baud", static_cast<std::uint32_t>(line.mode.baud)},
      {"parity", config::word_for(config::kParities, line.mode.format.parity)},
      {"stop_bits", line.mode.format.stop_bits}};
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
  return fmt::format(
      "{}, {} baud, parity {}, stop bits {}:\n", line.device, fmt::underlying(line.mode.baud),
      config::word_for(config::kParities, line.mode.format.parity), line.mode.format.stop_bits);
}

bool word_order_unknown(const Identification& identification) {
  const auto& likely = identification.likely;
  return !identification.word_order && std::ranges::any_of(likely, [](const auto* it) {
    return it->profile.word_order_settable;
  });
}

std::string scan_json(const PortScan& scan, bool of_port,
                      const std::optional<std::string>& configuration,
                      const std::optional<std::string>& error) {
  boost::json::array units;
  for (const auto& unit : scan.result.found) {
    units.push_back(unit_json(unit));
  }
  boost::json::object object{{"units", std::move(units)},
                             {"busy", boost::json::value_from(scan.result.busy)},
                             {"configuration", boost::json::value_from(configuration)}};
  if (error) {
    object["error"] = *error;
  }
  if (of_port) {
    object["line"] = scan.line ? line_json(*scan.line) : boost::json::value(nullptr);
    object["notes"] = boost::json::value_from(scan.notes);
  }
  return boost::json::serialize(object);
}

}  // namespace mbgate::ctl
