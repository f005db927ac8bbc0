// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <sstream>

#include "ctl/request/carry_out.hpp"
#include "ctl/scan/scan.hpp"

namespace mbgate::ctl::scan_command_test {
namespace {

using modbus::Table;
using modbus::TableRange;

modbus::Pdu pdu(const std::vector<std::uint8_t>& bytes) { return *modbus::Pdu::from(bytes); }

/// A port that nobody listens on, kept from others while it is asked for.
class ClosedPort {
 public:
  ClosedPort() : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(bind(socket_, generic, size), 0);
    EXPECT_EQ(getsockname(socket_, generic, &size), 0);
    number = ntohs(address.sin_port);
  }
  ~ClosedPort() { close(socket_); }
  ClosedPort(const ClosedPort&) = delete;
  ClosedPort& operator=(const ClosedPort&) = delete;

  std::uint16_t number = 0;

 private:
  int socket_;
};

TEST(ScanAnswer, IsDataOfRegistersAndOfBits) {
  const auto registers =
      answer_of({Table::holding_registers, 7, 2}, pdu({0x03, 0x04, 0x12, 0x34, 0, 5}));
  EXPECT_EQ(registers.kind, AnswerKind::data);
  EXPECT_EQ(registers.registers, (std::vector<std::uint16_t>{0x1234, 5}));
  const auto bits = answer_of({Table::coils, 0, 3}, pdu({0x01, 0x01, 0b101}));
  EXPECT_EQ(bits.kind, AnswerKind::data);
  EXPECT_EQ(bits.registers, (std::vector<std::uint16_t>{1, 0, 1}));
}

TEST(ScanAnswer, TellsWhatTheDeviceRefusesFromWhatTheGatewayCannot) {
  const auto kind = [](std::uint8_t code) {
    return answer_of({Table::holding_registers, 0, 1}, pdu({0x83, code})).kind;
  };
  EXPECT_EQ(kind(0x01), AnswerKind::exception);
  EXPECT_EQ(kind(0x02), AnswerKind::exception);
  EXPECT_EQ(kind(0x11), AnswerKind::exception);
  EXPECT_EQ(kind(0x05), AnswerKind::busy);
  EXPECT_EQ(kind(0x06), AnswerKind::busy);
  EXPECT_EQ(kind(0x0A), AnswerKind::no_way);
  EXPECT_EQ(kind(0x0B), AnswerKind::silence);
  EXPECT_EQ(answer_of({Table::holding_registers, 0, 1}, pdu({0x83, 0x11})).exception, 0x11);
}

struct Outcome {
  int status;
  std::string output;
  std::string errors;
};

Outcome carry_out(ScanCommand command, const std::filesystem::path& profiles) {
  const ClosedPort port;
  command.target.port = port.number;
  command.units = {1, 2};
  command.folder = profiles;
  std::ostringstream out;
  std::ostringstream errors;
  const int status = run(command, out, errors);
  auto text = errors.str();
  const auto number = std::to_string(port.number);
  if (const auto at = text.find(number); at != std::string::npos) {
    text.replace(at, number.size(), "PORT");
  }
  return {status, out.str(), text};
}

TEST(CarryOutScan, EndsWhereNobodyListens) {
  const auto outcome = carry_out({}, MBGATE_SOURCE_DIR "/conf/profiles");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.output, "");
  EXPECT_EQ(outcome.errors, "mbgatectl: cannot connect to 127.0.0.1:PORT: Connection refused\n");
}

TEST(CarryOutScan, SaysInJsonThatNobodyListens) {
  ScanCommand command;
  command.json = true;
  const auto outcome = carry_out(command, MBGATE_SOURCE_DIR "/conf/profiles");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.errors, "");
  EXPECT_THAT(outcome.output, testing::StartsWith(R"({"units":[],"busy":[],"configuration":null,)"
                                                  R"("error":"cannot connect to 127.0.0.1:)"));
}

TEST(CarryOutScan, NeedsProfilesToCompareWith) {
  const auto outcome = carry_out({}, MBGATE_SOURCE_DIR "/src");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.errors,
            "mbgatectl: there is no profile to compare with in " MBGATE_SOURCE_DIR "/src\n");
}

TEST(CarryOutScan, AsksNobodyIfTheFileIsThere) {
  ScanCommand command;
  command.config = MBGATE_SOURCE_DIR "/conf/mbgate.toml";
  const auto outcome = carry_out(command, MBGATE_SOURCE_DIR "/conf/profiles");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.errors, "mbgatectl: " MBGATE_SOURCE_DIR "/conf/mbgate.toml already exists\n");
}

}  // namespace
}  // namespace mbgate::ctl::scan_command_test
