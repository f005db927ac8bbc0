// SPDX-License-Identifier: Apache-2.0
// Ports that are set otherwise than the drives, and adapters that hear themselves.
#include <gtest/gtest.h>

#include "integration/plant.hpp"

namespace mbgate::test {
namespace {

/// The answer to a read: its function and what follows.
std::string read_answer(const PlantOptions& options) {
  Plant plant(options);
  TcpClient client(plant.port(0));
  client.send(request(1, 1, "03 003C 0002"));
  const auto answer = client.receive();
  return answer && answer->size() > 7 ? text_of({answer->begin() + 7, answer->end()}) : "";
}

constexpr auto kRegisters = "03 04 00 00 00 00";
constexpr auto kNoAnswer = "83 0B";

TEST(LineMode, DrivesAnswerAtTheirOwnBaudRateAndStopBitsOnly) {
  EXPECT_EQ(read_answer({.paced = true}), kRegisters);
  const std::string soon = "300ms";
  EXPECT_EQ(read_answer({.paced = true, .baud = 57600, .response_timeout = soon}), kNoAnswer);
  EXPECT_EQ(read_answer({.paced = true, .response_timeout = soon, .bus = "stop_bits = 2"}),
            kNoAnswer);
}

TEST(LineMode, AnAdapterThatHearsItselfIsServed) {
  for (const auto* delay : {"0ms", "8ms"}) {
    EXPECT_EQ(
        read_answer({.paced = true,
                     .bus = "echo = true",
                     .simulated_bus = std::string("echo = true\necho_delay = \"") + delay + "\""}),
        kRegisters)
        << delay;
  }
}

}  // namespace
}  // namespace mbgate::test
