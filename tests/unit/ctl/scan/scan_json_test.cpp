// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "ctl/scan/scan_report.hpp"
#include "found_units.hpp"

namespace mbgate::ctl {
namespace {

TEST(ScanJson, SaysOfEachUnitWhatTheTableSays) {
  const auto json =
      boost::json::parse(scan_json({plant()}, false, "# found\n[[bus]]\n", std::nullopt));
  EXPECT_EQ(json, boost::json::parse(R"({
    "units": [
      {"unit": 1, "functions": [3], "slowest_ms": 4, "profiles": ["moons-st"],
       "nearest": "moons-m2", "fitting": 9, "judged": 9, "word_order": "unknown", "texts": [],
       "fell_silent": false},
      {"unit": 3, "functions": [3], "slowest_ms": 4, "profiles": ["moons-m3"],
       "nearest": "moons-m2", "fitting": 9, "judged": 9, "word_order": "little", "texts": [],
       "fell_silent": false},
      {"unit": 4, "functions": [3], "slowest_ms": 4, "profiles": ["moons-ssdc", "moons-stb"],
       "nearest": "moons-m2", "fitting": 9, "judged": 9, "word_order": "big", "texts": [],
       "fell_silent": false},
      {"unit": 17, "functions": [3], "slowest_ms": 4, "profiles": ["autonics-aic"],
       "nearest": "moons-m2", "fitting": 9, "judged": 9, "word_order": "big",
       "texts": [{"name": "model name", "text": "AiC-D-56LA"}], "fell_silent": false},
      {"unit": 32, "functions": [3], "slowest_ms": 120, "profiles": [],
       "nearest": "moons-m2", "fitting": 4, "judged": 9, "word_order": null, "texts": [],
       "fell_silent": true}],
    "busy": [],
    "configuration": "# found\n[[bus]]\n"})"));
}

TEST(ScanJson, SaysWhyNothingWasFound) {
  ScanResult result;
  result.busy = {7};
  EXPECT_EQ(scan_json({result}, false, std::nullopt, "no other unit answered"),
            R"({"units":[],"busy":[7],"configuration":null,"error":"no other unit answered"})");
}

TEST(ScanJson, HasTheLineAndTheNotesOfASerialPort) {
  PortScan scan;
  scan.notes = {"interference"};
  EXPECT_EQ(scan_json(scan, true, std::nullopt, "interrupted"),
            R"({"units":[],"busy":[],"configuration":null,"error":"interrupted","line":null,)"
            R"("notes":["interference"]})");
  scan.line = FoundLine{"/dev/ttyUSB0", std::nullopt, {modbus::Baud{9600}, {}}};
  const auto json = boost::json::parse(scan_json(scan, true, std::nullopt, std::nullopt));
  EXPECT_EQ(json.at("line"), boost::json::parse(R"({"device": "/dev/ttyUSB0", "baud": 9600,
                                                    "parity": "even", "stop_bits": 1})"));
}

}  // namespace
}  // namespace mbgate::ctl
