// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "ctl/request/modbus_client.hpp"
#include "modbus/request.hpp"
#include "scripted_server.hpp"

namespace mbgate::ctl {
namespace {

using Answers = ScriptedServer::Answers;

const modbus::Request kOneRegister = modbus::make_read({Table::holding_registers, 0, 1});
const ScriptedServer::Bytes kAnswer{1, 0x03, 0x02, 0x00, 0x05};

Connection connection_to(const ScriptedServer& server) {
  Target target;
  target.port = server.port();
  return Connection(target);
}

TEST(Connection, IsKeptFromRequestToRequest) {
  const ScriptedServer server(std::vector<Answers>{{kAnswer, {1, 0x83, 0x0B}, kAnswer}});
  auto connection = connection_to(server);
  EXPECT_TRUE(connection.ask(kOneRegister));
  const auto exception = connection.ask(kOneRegister);
  ASSERT_FALSE(exception);
  EXPECT_EQ(exception.error().status, 1);
  EXPECT_EQ(exception.error().exception, 0x0B);
  EXPECT_TRUE(connection.ask(kOneRegister));
}

TEST(Connection, WaitsForAWholeAnswerAsLongAsForItsFirstByte) {
  using namespace std::chrono;
  const ScriptedServer server(std::vector<Answers>{{kAnswer, {}}},
                              [](ScriptedServer::Bytes& adu) { adu.pop_back(); });
  Target target;
  target.port = server.port();
  target.timeout = milliseconds(700);
  Connection connection(target);
  const auto start = steady_clock::now();
  const auto answer = connection.ask(kOneRegister);
  EXPECT_GE(steady_clock::now() - start, milliseconds(690));
  ASSERT_FALSE(answer);
  EXPECT_THAT(answer.error().text, testing::HasSubstr("within 700ms"));
}

TEST(Connection, IsMadeAnewIfTheServerHasClosedIt) {
  const ScriptedServer server(std::vector<Answers>{{kAnswer}, {kAnswer}});
  auto connection = connection_to(server);
  EXPECT_TRUE(connection.ask(kOneRegister));
  server.wait_until_one_is_closed();
  EXPECT_TRUE(connection.ask(kOneRegister));
}

TEST(Connection, IsMadeAnewAfterAResponseThatDidNotCome) {
  const ScriptedServer server(std::vector<Answers>{{kAnswer, {}}, {kAnswer}});
  auto connection = connection_to(server);
  EXPECT_TRUE(connection.ask(kOneRegister));
  const auto lost = connection.ask(kOneRegister);
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().exception, std::nullopt);
  EXPECT_TRUE(connection.ask(kOneRegister));
}

}  // namespace
}  // namespace mbgate::ctl
