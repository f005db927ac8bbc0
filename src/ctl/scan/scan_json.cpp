// SPDX-License-Identifier: Apache-2.0
#include <boost/json.hpp>

#include "config/toml/words.hpp"
#include "ctl/scan/scan_report.hpp"

namespace mbgate::ctl {
namespace {

boost::json::value word_order_json(const Identification& found) {
  if (word_order_unknown(found)) {
    return "unknown";
  }
  if (!found.word_order) {
    return nullptr;
  }
  const auto word = config::order_word(*found.word_order);
  return boost::json::string_view(word.data(), word.size());
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
  boost::json::array functions;
  for (std::size_t function = 1; function < found.functions.size(); ++function) {
    if (found.functions.test(function)) {
      functions.emplace_back(function);
    }
  }
  boost::json::array profiles;
  for (const auto* file : found.likely) {
    profiles.emplace_back(file->profile.name);
  }
  const boost::json::value nearest =
      found.nearest != nullptr ? boost::json::value(found.nearest->profile.name) : nullptr;
  return {{"unit", unit.unit},
          {"functions", std::move(functions)},
          {"slowest_ms", std::chrono::ceil<std::chrono::milliseconds>(unit.slowest).count()},
          {"profiles", std::move(profiles)},
          {"nearest", nearest},
          {"fitting", found.fitting},
          {"judged", found.judged},
          {"word_order", word_order_json(found)},
          {"texts", texts_json(found.texts)},
          {"fell_silent", unit.fell_silent}};
}

boost::json::object result_json(const ScanResult& result,
                                const std::optional<std::string>& configuration,
                                const std::optional<std::string>& error) {
  boost::json::array units;
  for (const auto& unit : result.found) {
    units.push_back(unit_json(unit));
  }
  boost::json::array busy;
  for (const auto unit : result.busy) {
    busy.emplace_back(unit);
  }
  boost::json::object object{{"units", std::move(units)}, {"busy", std::move(busy)}};
  object["configuration"] = nullptr;
  if (configuration) {
    object["configuration"] = *configuration;
  }
  if (error) {
    object["error"] = *error;
  }
  return object;
}

boost::json::value line_json(const FoundLine& line) {
  const auto parity = parity_word(line.mode.format.parity);
  return boost::json::object{{"device", line.device},
                             {"baud", static_cast<std::uint32_t>(line.mode.baud)},
                             {"parity", boost::json::string_view(parity.data(), parity.size())},
                             {"stop_bits", line.mode.format.stop_bits}};
}

}  // namespace

std::string scan_json(const ScanResult& result, const std::optional<std::string>& configuration,
                      const std::optional<std::string>& error) {
  return boost::json::serialize(result_json(result, configuration, error));
}

std::string scan_json(const PortScan& scan, const std::optional<std::string>& configuration,
                      const std::optional<std::string>& error) {
  auto object = result_json(scan.result, configuration, error);
  object["line"] = scan.line ? line_json(*scan.line) : boost::json::value(nullptr);
  boost::json::array notes;
  for (const auto& note : scan.notes) {
    notes.emplace_back(note);
  }
  object["notes"] = std::move(notes);
  return boost::json::serialize(object);
}

}  // namespace mbgate::ctl
