// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/status_text.hpp"

#include <gtest/gtest.h>

#include <boost/json.hpp>

namespace mbgate::ctl {
namespace {

boost::json::object listed(const char* name, const char* state, const char* exceptions,
                           const boost::json::value& since = 5) {
  const boost::json::object none{{"p50", nullptr}, {"p90", nullptr}, {"p99", nullptr}};
  return {{"name", name},
          {"bus", "line-a"},
          {"address", 1},
          {"state", state},
          {"state_since_s", since},
          {"unanswered_in_row", 0},
          {"quality", {{"verdict", "good"}, {"count", 0}, {"of", 5}}},
          {"latency_ms", {{"queue", none}, {"wire", none}, {"device", none}}},
          {"counters", {{"responses", 5}, {"timeouts", 0}, {"bad_crcs", 0}, {"late_responses", 0}}},
          {"exceptions", boost::json::parse(exceptions)}};
}

// Of the devices, after an empty line, and without the line that explains columns.
std::string device_table(const boost::json::array& devices) {
  const std::string text = status_text(
      {{"version", "1"},
       {"uptime_s", 7},
       {"configuration", {{"file", "f"}, {"read_at", "now"}, {"reload_refused", false}}},
       {"requests", 5},
       {"diagnoses", boost::json::array()},
       {"buses", boost::json::array()},
       {"devices", devices},
       {"clients", boost::json::array()}});
  const auto begin = text.find("\nDEVICE");
  return text.substr(begin, text.find("QUEUE, WIRE, DRIVE") - begin);
}

TEST(StatusText, HasExceptionsBelowTheirDevice) {
  EXPECT_EQ(device_table({listed("axis", "answering", R"({"02":3,"09":1,"other":12})"),
                          listed("lift", "answering", "{}")}),
            R"(
DEVICE  BUS     ADDRESS  STATE      ANSWERS  TIMEOUTS  BAD CRC  LATE  QUEUE  WIRE  DRIVE  P90  P99
axis    line-a  1        answering        5         0        0     0      -     -      -    -    -
    exceptions: 02 (illegal data address): 3, 09: 1, other codes: 12
lift    line-a  1        answering        5         0        0     0      -     -      -    -    -
)");
}

TEST(StatusText, NamesTheConfigurationByItsDigest) {
  boost::json::object configuration{{"file", "f"}, {"read_at", "now"}, {"reload_refused", false}};
  const auto shown = [&configuration] {
    return status_text({{"version", "1"},
                        {"uptime_s", 7},
                        {"configuration", configuration},
                        {"requests", 5},
                        {"diagnoses", boost::json::array()},
                        {"buses", boost::json::array()},
                        {"devices", boost::json::array()},
                        {"clients", boost::json::array()}});
  };
  EXPECT_EQ(shown().find("sha256"), std::string::npos);
  configuration["sha256"] = "ba78";
  EXPECT_NE(shown().find("5 requests\nConfiguration: sha256 ba78\n"), std::string::npos);
}

TEST(StatusText, SaysForHowLongADeviceIsNotWell) {
  EXPECT_EQ(device_table({listed("axis", "answering", "{}", 9000),
                          listed("fan", "not asked", "{}", nullptr),
                          listed("lift", "offline", "{}", 251.5)}),
            R"(
DEVICE  BUS     ADDRESS  STATE              ANSWERS  TIMEOUTS  BAD CRC  LATE  QUEUE  WIRE  DRIVE  P90  P99
lift    line-a  1        offline for 4 min        5         0        0     0      -     -      -    -    -
axis    line-a  1        answering                5         0        0     0      -     -      -    -    -
fan     line-a  1        not asked                5         0        0     0      -     -      -    -    -
)");
}

TEST(StatusText, HasADeviceWithBadAnswersBeforeThoseThatAreOnlySlow) {
  auto slow = listed("axis", "answering", "{}");
  slow["latency_ms"].as_object()["device"].as_object()["p90"] = 120;
  auto bad = listed("lift", "answering", "{}");
  bad["quality"].as_object()["verdict"] = "bad crc";
  auto silent = listed("pump", "not answering", "{}");
  const std::string table = device_table({slow, bad, silent});
  EXPECT_LT(table.find("pump"), table.find("lift"));
  EXPECT_LT(table.find("lift"), table.find("axis"));
}

}  // namespace
}  // namespace mbgate::ctl
