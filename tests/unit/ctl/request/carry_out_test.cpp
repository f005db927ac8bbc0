// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/carry_out.hpp"

#include <gtest/gtest.h>

#include <sstream>
#include <vector>

#include "scripted_server.hpp"

namespace mbgate::ctl {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Answers one request with these bytes; no bytes: it closes.
class OneAnswer : public ScriptedServer {
 public:
  explicit OneAnswer(
      Bytes unit_and_pdu, std::function<void(Bytes&)> spoil = [](Bytes&) {})
      : ScriptedServer(std::vector<Answers>{Answers{std::move(unit_and_pdu)}}, std::move(spoil)) {}
};

struct Outcome {
  int status;
  std::string output;
  std::string errors;
};

template <typename AnyCommand>
Outcome carry_out_on(std::uint16_t port, AnyCommand command) {
  command.target.port = port;
  std::ostringstream out;
  std::ostringstream errors;
  const int status = carry_out(command, out, errors);
  return {status, out.str(), errors.str()};
}

ReadCommand read_position() {
  ReadCommand command;
  command.place = {Table::holding_registers, 0x1E, ValueType::i32, drive::WordOrder::big};
  return command;
}

WriteCommand write_opcode() {
  WriteCommand command;
  command.place = {Table::holding_registers, 0x7C, ValueType::u16, drive::WordOrder::big};
  command.values = {0xD8};
  return command;
}

TEST(CarryOut, PrintsWhatWasRead) {
  const OneAnswer server({1, 0x03, 0x04, 0x00, 0x03, 0x0D, 0x40});
  const auto outcome = carry_out_on(server.port(), read_position());
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.output, "30: 200000 (0x00030D40)\n");
  EXPECT_EQ(outcome.errors, "");
}

TEST(CarryOut, PrintsPlainValuesForScripts) {
  const OneAnswer server({1, 0x03, 0x04, 0x00, 0x03, 0x0D, 0x40});
  auto command = read_position();
  command.quiet = true;
  EXPECT_EQ(carry_out_on(server.port(), command).output, "200000\n");
}

TEST(CarryOut, PrintsWhatWasWritten) {
  const OneAnswer server({1, 0x06, 0x00, 0x7C, 0x00, 0xD8});
  const auto outcome = carry_out_on(server.port(), write_opcode());
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.output, "124: 216 (0x00D8) written\n");
}

TEST(CarryOut, NamesAnExceptionOfTheStandard) {
  const OneAnswer server({1, 0x83, 0x02});
  const auto outcome = carry_out_on(server.port(), read_position());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.output, "");
  EXPECT_EQ(outcome.errors,
            "mbgatectl: unit 1: exception 0x02 (illegal data address): there is no such register "
            "or coil, or it "
            "lies outside every window of the route\n");
}

TEST(CarryOut, ShowsTheNumberOfAMakersException) {
  const OneAnswer server({1, 0x86, 0x12});
  const auto outcome = carry_out_on(server.port(), write_opcode());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.errors,
            "mbgatectl: unit 1: exception 0x12: a code of the device's maker; its manual says what "
            "it means\n");
}

TEST(CarryOut, SaysThatAWriteMayHaveBeenDone) {
  EXPECT_EQ(explain_exception(0x0B, true),
            "exception 0x0B (gateway target device failed to respond): no valid answer came; the "
            "write may have been done");
  EXPECT_EQ(explain_exception(0x0B, false),
            "exception 0x0B (gateway target device failed to respond): no valid answer came");
}

TEST(CarryOut, TakesNoAnswerThatDoesNotFit) {
  const auto complaint = [](
                             Bytes answer, const auto& command,
                             std::function<void(Bytes&)> spoil = [](Bytes&) {}) {
    const OneAnswer server(std::move(answer), std::move(spoil));
    const auto outcome = carry_out_on(server.port(), command);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.output, "");
    const std::string head =
        "mbgatectl: the response of 127.0.0.1:" + std::to_string(server.port()) +
        " does not fit the request: ";
    EXPECT_EQ(outcome.errors.substr(0, head.size()), head);
    return outcome.errors.substr(std::min(head.size(), outcome.errors.size()));
  };
  const std::string done = "; the write may have been done\n";
  const Bytes good{1, 0x06, 0x00, 0x7C, 0x00, 0xD8};
  EXPECT_EQ(complaint({2, 0x06, 0x00, 0x7C, 0x00, 0xD8}, write_opcode()),
            "it is from unit 2" + done);
  EXPECT_EQ(complaint({2, 0x03, 0x04, 0x00, 0x03, 0x0D, 0x40}, read_position()),
            "it is from unit 2\n");
  EXPECT_EQ(complaint({1, 0x03, 0x02, 0x00, 0x01}, write_opcode()),
            "it has another function" + done);
  EXPECT_EQ(complaint({1, 0x06, 0x00, 0x7D, 0x00, 0xD8}, write_opcode()),
            "it repeats another address, value or quantity" + done);
  EXPECT_EQ(complaint({1, 0x06, 0x00, 0x7C, 0x00, 0x64}, write_opcode()),
            "it has the value 100, not 216 (some drives limit what is written)" + done);
  EXPECT_EQ(complaint(good, write_opcode(), [](Bytes& adu) { ++adu[5]; }),
            "it is not a Modbus TCP response" + done);
  EXPECT_EQ(complaint(good, write_opcode(), [](Bytes& adu) { ++adu[1]; }),
            "it has another transaction identifier" + done);
}

TEST(CarryOut, FailsWhereNothingCanBePrinted) {
  const OneAnswer server({1, 0x06, 0x00, 0x7C, 0x00, 0xD8});
  auto command = write_opcode();
  command.target.port = server.port();
  std::ostringstream out;
  out.setstate(std::ios::badbit);
  std::ostringstream errors;
  EXPECT_EQ(carry_out(command, out, errors), 1);
  EXPECT_EQ(errors.str(), "mbgatectl: done, but the result cannot be written to standard output\n");
}

TEST(CarryOut, SaysThatTheServerHungUp) {
  const OneAnswer server({});
  const auto outcome = carry_out_on(server.port(), write_opcode());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.errors,
            "mbgatectl: 127.0.0.1:" + std::to_string(server.port()) +
                " closed the connection without an answer; the write may have been done\n");
}

TEST(CarryOut, SaysThatNobodyListens) {
  std::uint16_t port = 0;
  {
    const OneAnswer server({});
    port = server.port();
    carry_out_on(port, read_position());
  }
  const auto outcome = carry_out_on(port, read_position());
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.errors, "mbgatectl: cannot connect to 127.0.0.1:" + std::to_string(port) +
                                ": Connection refused\n");
}

TEST(CarryOut, ReadsAndWritesAText) {
  ReadCommand read;
  read.place = {Table::holding_registers, 0x10, ValueType::text, drive::WordOrder::big};
  read.count = 3;
  const Bytes answer{1, 0x03, 0x06, 'A', 'i', 'C', 0x1B, 0x00, 'x'};
  EXPECT_EQ(carry_out_on(OneAnswer(answer).port(), read).output, "16: \"AiC\\x1B\"\n");
  read.quiet = true;
  EXPECT_EQ(carry_out_on(OneAnswer(answer).port(), read).output, "AiC\\x1B\n");
  WriteCommand write;
  write.place = read.place;
  write.values = {0x4169, 0x4300};
  const OneAnswer server({1, 0x10, 0x00, 0x10, 0x00, 0x02});
  EXPECT_EQ(carry_out_on(server.port(), write).output, "16: \"AiC\" written\n");
}

TEST(CarryOut, SaysInJsonWhatCame) {
  auto read = read_position();
  read.json = true;
  const OneAnswer answering({1, 0x03, 0x04, 0x00, 0x03, 0x0D, 0x40});
  auto outcome = carry_out_on(answering.port(), read);
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.output,
            R"({"unit":1,"table":"holding","values":[{"address":30,"value":200000}]})"
            "\n");
  auto write = write_opcode();
  write.json = true;
  const OneAnswer refusing({1, 0x86, 0x12});
  outcome = carry_out_on(refusing.port(), write);
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.output,
            R"({"error":"unit 1: exception 0x12: a code of the device's maker; its manual says )"
            R"(what it means","exception":18})"
            "\n");
  EXPECT_EQ(outcome.errors, "");
}

TEST(CarryOut, SaysInJsonWhyNothingCame) {
  auto command = read_position();
  command.json = true;
  const OneAnswer server({});
  auto outcome = carry_out_on(server.port(), command);
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.output, R"({"error":"127.0.0.1:)" + std::to_string(server.port()) +
                                R"( closed the connection without an answer"})"
                                "\n");
  command.count = 63;
  outcome = carry_out_on(1, command);
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.output, R"({"error":"63 values do not fit into one request: 1 to 62"})"
                            "\n");
}

TEST(CarryOut, RefusesWhatDoesNotFitIntoARequest) {
  auto command = read_position();
  command.count = 63;
  const auto outcome = carry_out_on(1, command);
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.errors, "mbgatectl: 63 values do not fit into one request: 1 to 62\n");
}

}  // namespace
}  // namespace mbgate::ctl
