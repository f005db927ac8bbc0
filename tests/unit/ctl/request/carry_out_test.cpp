// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/carry_out.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <sstream>
#include <thread>
#include <vector>

namespace mbgate::ctl {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A server on a free port that answers one request: its MBAP header and then these bytes. No
/// bytes: it closes.
class OneAnswer {
 public:
  explicit OneAnswer(Bytes unit_and_pdu) : listener_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(bind(listener_, generic, size), 0);
    EXPECT_EQ(getsockname(listener_, generic, &size), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this, answer = std::move(unit_and_pdu)] { serve(answer); });
  }
  ~OneAnswer() {
    thread_.join();
    close(listener_);
  }
  OneAnswer(const OneAnswer&) = delete;
  OneAnswer& operator=(const OneAnswer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }

 private:
  void serve(const Bytes& answer) const {
    pollfd ready{.fd = listener_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, 10'000) != 1) {
      return;
    }
    const int client = accept(listener_, nullptr, nullptr);
    std::array<std::uint8_t, 260> request{};
    if (recv(client, request.data(), request.size(), 0) > 0 && !answer.empty()) {
      Bytes response(request.begin(), request.begin() + 4);
      response.push_back(0);
      response.push_back(static_cast<std::uint8_t>(answer.size()));
      response.insert(response.end(), answer.begin(), answer.end());
      send(client, response.data(), response.size(), MSG_NOSIGNAL);
    }
    close(client);
  }

  int listener_;
  std::uint16_t port_ = 0;
  std::thread thread_;
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
  const auto complaint = [](Bytes answer, const WriteCommand& command) {
    const OneAnswer server(std::move(answer));
    const auto outcome = carry_out_on(server.port(), command);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.output, "");
    const std::string head =
        "mbgatectl: the response of 127.0.0.1:" + std::to_string(server.port()) +
        " does not fit the request: ";
    EXPECT_EQ(outcome.errors.substr(0, head.size()), head);
    return outcome.errors.substr(std::min(head.size(), outcome.errors.size()));
  };
  EXPECT_EQ(complaint({2, 0x06, 0x00, 0x7C, 0x00, 0xD8}, write_opcode()), "it is of unit 2\n");
  EXPECT_EQ(complaint({1, 0x03, 0x02, 0x00, 0x01}, write_opcode()), "it is of another function\n");
  EXPECT_EQ(complaint({1, 0x06, 0x00, 0x7D, 0x00, 0xD8}, write_opcode()),
            "it repeats another address, value or quantity\n");
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

TEST(CarryOut, RefusesWhatDoesNotFitIntoARequest) {
  auto command = read_position();
  command.count = 63;
  const auto outcome = carry_out_on(1, command);
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.errors, "mbgatectl: 63 values do not fit into one request: 1 to 62\n");
}

}  // namespace
}  // namespace mbgate::ctl
