// SPDX-License-Identifier: Apache-2.0
// Modbus TCP servers that close connections, or answer as another unit.
#include "integration/near_gateway.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;

TEST(Downstream, ServesFromAServerThatClosesAfterEachAnswer) {
  FarServer far;
  far.close_after_answers();
  NearGateway near(far.port(), kPatient);
  TcpClient client = near.client();
  const std::size_t before = far.connections();
  for (int times = 0; times < 20; ++times) {
    EXPECT_EQ(ask(client, kRead), "03 02 03 F2");
  }
  EXPECT_GE(far.connections() - before, 19U);
  EXPECT_EQ(near.process().output().find("is lost"), std::string::npos) << near.process().output();
}

TEST(Downstream, OpensAnIdleConnectionAgainForAWrite) {
  FarServer far;
  NearGateway near(far.port(), kPatient);
  TcpClient client = near.client();
  EXPECT_EQ(ask(client, "03 011C 0001"), "03 02 05 04");  // the server closes behind this answer
  EXPECT_EQ(ask(client, kRead), "03 02 03 F2");
  EXPECT_EQ(ask(client, "06 0014 0001"), "06 00 14 00 01");
  EXPECT_EQ(far.connections(), 2U);
}

TEST(Downstream, AsksAReadOnceMoreThatACloseHasCutAndAWriteNever) {
  FarServer far;
  NearGateway near(far.port(), kPatient);
  TcpClient client = near.client();
  const auto asked = [&far] {
    return std::ranges::count(far.arrivals(), unsigned{FarServer::kCuttingRegister},
                              &Arrival::address);
  };
  EXPECT_EQ(ask(client, "03 011D 0001"), "03 02 05 05");
  EXPECT_EQ(asked(), 2);
  EXPECT_EQ(ask(client, "06 011D 0001"), "86 0B");
  EXPECT_EQ(asked(), 3);
  EXPECT_EQ(ask(client, kRead), "03 02 03 F2");
}

TEST(Downstream, BacksOffFromAServerThatClosesWhatItAccepts) {
  FarServer far;
  NearGateway near(far.port(), kPatient);
  TcpClient client = near.client();
  far.close_at_once(true);
  EXPECT_EQ(ask(client, "03 011C 0001"), "03 02 05 04");
  const std::size_t before = far.connections();
  const auto begin = std::chrono::steady_clock::now();
  for (int times = 0; times < 40; ++times) {
    EXPECT_TRUE(ask(client, kRead).starts_with("83 0"));
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  // A second's worth of tries, and one for each further second, however long this took.
  const auto taken = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(far.connections() - before, 10U + static_cast<std::size_t>(taken / 1s));
  far.close_at_once(false);
  EXPECT_TRUE(serves(client));
}

TEST(Downstream, TakesTheAnswersOfAServerThatHasOneUnitForAll) {
  FarServer far;
  far.answer_as(1);
  NearGateway near(far.port(), kPatient);
  TcpClient client = near.routed_client();
  EXPECT_EQ(ask(client, kRead, 5), "03 02 03 F2");
}

TEST(Downstream, ComparesTheUnitOfAnAnswerIfAskedTo) {
  FarServer far;
  far.answer_as(kUnit);
  NearGateway near(far.port(), std::string(kImpatient) + "\ncheck_unit = true");
  TcpClient client = near.routed_client();
  EXPECT_EQ(ask(client, kRead, 5), "83 0B");
}

}  // namespace
}  // namespace mbgate::test
