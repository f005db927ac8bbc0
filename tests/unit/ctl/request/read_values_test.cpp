// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "ctl/request/carry_out.hpp"
#include "scripted_server.hpp"

namespace mbgate::ctl {
namespace {

using namespace std::chrono_literals;
using Script = std::vector<ScriptedServer::Answers>;

const ScriptedServer::Bytes kFive{1, 0x03, 0x02, 0x00, 0x05};
const ScriptedServer::Bytes kSix{1, 0x03, 0x02, 0x00, 0x06};

struct Printed {
  int status;
  std::string output;
  std::string errors;
};

ReadCommand read_every_10ms(std::size_t times) {
  ReadCommand command;
  command.every = 10ms;
  command.times = times;
  return command;
}

Printed repeat(const ScriptedServer& server, ReadCommand command) {
  command.target.port = server.port();
  std::ostringstream out;
  std::ostringstream errors;
  const int status = carry_out(command, out, errors);
  return {status, out.str(), errors.str()};
}

TEST(RepeatedRead, HasTheTimeOfDayBeforeEachBlock) {
  const ScriptedServer server(Script{{kFive, kSix}});
  const auto printed = repeat(server, read_every_10ms(2));
  EXPECT_EQ(printed.status, 0);
  EXPECT_EQ(printed.errors, "");
  EXPECT_THAT(printed.output,
              testing::MatchesRegex("[0-9]+:[0-9]+:[0-9]+\\.[0-9]+\n0: 5 .0x0005.\n"
                                    "[0-9]+:[0-9]+:[0-9]+\\.[0-9]+\n0: 6 .0x0006.\n"));
}

TEST(RepeatedRead, GoesOnAfterAFailureOnANewConnection) {
  const ScriptedServer server(Script{{kFive, {1, 0x83, 0x06}, {}}, {kSix}});
  auto command = read_every_10ms(4);
  command.quiet = true;
  const auto printed = repeat(server, command);
  EXPECT_EQ(printed.status, 1);
  EXPECT_EQ(printed.output, "5\n6\n");
  EXPECT_EQ(
      printed.errors,
      "mbgatectl: unit 1: exception 0x06 (server device busy): the request was not carried "
      "out: gateway or device is busy, or it was a write to a device that does not answer; try "
      "again\n"
      "mbgatectl: 127.0.0.1:" +
          std::to_string(server.port()) + " closed the connection without an answer\n");
}

TEST(RepeatedRead, PrintsOneJsonObjectALine) {
  const ScriptedServer server(Script{{kFive, {1, 0x83, 0x12}}});
  auto command = read_every_10ms(2);
  command.json = true;
  const auto printed = repeat(server, command);
  EXPECT_EQ(printed.status, 1);
  EXPECT_EQ(printed.errors, "");
  EXPECT_EQ(printed.output,
            R"({"unit":1,"table":"holding","values":[{"address":0,"value":5}]})"
            "\n"
            R"({"error":"unit 1: exception 0x12: a code of the device's maker; its manual says )"
            R"(what it means","exception":18})"
            "\n");
}

TEST(RepeatedRead, ThatFitsIntoNoRequestIsNotBegun) {
  auto command = read_every_10ms(2);
  command.count = 126;
  std::ostringstream out;
  std::ostringstream errors;
  EXPECT_EQ(carry_out(command, out, errors), 2);
  EXPECT_EQ(errors.str(), "mbgatectl: 126 values do not fit into one request: 1 to 125\n");
}

}  // namespace
}  // namespace mbgate::ctl
