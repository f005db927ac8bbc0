// SPDX-License-Identifier: Apache-2.0
#include "ctl/serial/serial_client.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <thread>

#include "terminal.hpp"

namespace mbgate::ctl {
namespace {

using std::chrono::steady_clock;

constexpr modbus::TableRange kRead{modbus::Table::holding_registers, 0, 1};
constexpr std::chrono::seconds kLong(30);
constexpr std::chrono::milliseconds kShort(1);
constexpr auto kGoOn = [] { return false; };
constexpr LineMode kMode{modbus::Baud{9600}, {8, modbus::Parity::even, 1}};

/// Takes one request of 8 bytes and gives these bytes back.
void reply_once(int end, const std::vector<std::uint8_t>& bytes) {
  std::array<std::uint8_t, 8> request{};
  std::size_t taken = 0;
  while (taken < request.size()) {
    const auto size = ::read(end, request.data() + taken, request.size() - taken);
    ASSERT_GT(size, 0);
    taken += static_cast<std::size_t>(size);
  }
  ASSERT_EQ(::write(end, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
}

std::vector<std::uint8_t> data_of(std::uint8_t unit) {
  const std::vector<std::uint8_t> pdu{0x03, 0x02, 0x12, 0x34};
  const auto frame = modbus::encode_rtu(unit, *modbus::Pdu::from(pdu));
  return {frame.begin(), frame.end()};
}

/// Asks unit 1 of a line where `bytes` come back.
Heard hear(const std::vector<std::uint8_t>& bytes, std::chrono::nanoseconds wait,
           std::optional<steady_clock::duration>* pause = nullptr) {
  const Terminal terminal;
  auto client = SerialClient::open(terminal.path);
  EXPECT_TRUE(client);
  EXPECT_EQ(client->set_mode(kMode), std::nullopt);
  std::thread other(reply_once, terminal.other_end(), bytes);
  const auto begin = steady_clock::now();
  const auto heard = client->ask(1, kRead, wait);
  other.join();
  EXPECT_TRUE(heard);
  if (pause != nullptr) {
    *pause = client->ready_at() - begin;
  }
  return *heard;
}

TEST(SerialClient, TakesAnAnswerAsSoonAsItIsWhole) {
  const auto heard = hear(data_of(1), kLong);
  EXPECT_EQ(heard.kind, HeardKind::answer);
  EXPECT_LT(heard.took, kLong);
}

TEST(SerialClient, WaitsFor35CharactersAndLongerAfterWhatItDidNotUnderstand) {
  std::optional<steady_clock::duration> pause;
  hear(data_of(1), kLong, &pause);
  EXPECT_GE(pause, modbus::RtuTiming(kMode.baud, kMode.format).t3_5());
  EXPECT_EQ(hear({0xFF, 0xFE}, std::chrono::milliseconds(100), &pause).kind, HeardKind::noise);
  EXPECT_GE(pause, std::chrono::milliseconds(100) + kPauseAfterNoise);
}

TEST(SerialClient, HearsSilence) {
  const Terminal terminal;
  auto client = SerialClient::open(terminal.path);
  ASSERT_TRUE(client);
  ASSERT_EQ(client->set_mode(kMode), std::nullopt);
  const auto heard = client->ask(1, kRead, kShort);
  ASSERT_TRUE(heard);
  EXPECT_EQ(heard->kind, HeardKind::silence);
}

std::vector<std::uint8_t> bytes_of(const std::vector<Piece>& pieces) {
  std::vector<std::uint8_t> bytes;
  for (const auto& piece : pieces) {
    bytes.insert(bytes.end(), piece.bytes.begin(), piece.bytes.end());
  }
  return bytes;
}

TEST(SerialClient, TakesWhatComesAfterTheAnswerToo) {
  const Terminal terminal;
  auto client = SerialClient::open(terminal.path);
  ASSERT_TRUE(client);
  ASSERT_EQ(client->set_mode(kMode), std::nullopt);
  auto both = data_of(1);
  both.insert(both.end(), both.begin(), both.end());
  std::thread other(reply_once, terminal.other_end(), both);
  const auto pieces =
      client->ask_all(SentRead(1, kRead), {kLong, std::chrono::milliseconds(50), kLong}, kGoOn);
  other.join();
  ASSERT_TRUE(pieces) << pieces.error();
  EXPECT_EQ(bytes_of(*pieces), both);
}

/// Asks unit 1 of a line where `bytes` come back, and says how long it took.
steady_clock::duration time_to_ask_all(const std::vector<std::uint8_t>& bytes,
                                       const ListenTimes& times) {
  const Terminal terminal;
  auto client = SerialClient::open(terminal.path);
  EXPECT_TRUE(client);
  EXPECT_EQ(client->set_mode(kMode), std::nullopt);
  std::thread other(reply_once, terminal.other_end(), bytes);
  const auto begin = steady_clock::now();
  const auto pieces = client->ask_all(SentRead(1, kRead), times, kGoOn);
  other.join();
  EXPECT_EQ(bytes_of(*pieces), bytes);
  return steady_clock::now() - begin;
}

TEST(SerialClient, WaitsNoLessForTheAnswerWhereOtherBytesCome) {
  constexpr std::chrono::seconds kWait(2);  // in which a busy machine hands over what is written
  EXPECT_GE(time_to_ask_all({0xFF}, {kWait, kShort, kShort}), kWait);
  EXPECT_GE(time_to_ask_all({0xFF, 0xFE, 0xFD, 0xFC, 0xFB}, {kWait, kShort, kShort}), kWait);
}

TEST(SerialClient, EndsWhereAWholeFrameHadItsTimeThoughBytesGoOnComing) {
  const Terminal terminal;
  auto client = SerialClient::open(terminal.path);
  ASSERT_TRUE(client);
  ASSERT_EQ(client->set_mode({modbus::Baud{115200}, {8, modbus::Parity::none, 1}}), std::nullopt);
  std::atomic<bool> over{false};
  std::thread other([&] {
    while (!over) {
      EXPECT_EQ(::write(terminal.other_end(), "\xFE", 1), 1);
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  });
  const auto pieces =
      client->ask_all(SentRead(1, kRead), {kShort, kShort, std::chrono::milliseconds(300)}, kGoOn);
  over = true;
  other.join();
  ASSERT_TRUE(pieces) << pieces.error();
  // Without an end it goes on until there are as many bytes as two frames have, for 26 s.
  EXPECT_LT(bytes_of(*pieces).size(), 2 * modbus::kMaxRtuSize);
}

TEST(SerialClient, EndsBeforeTheAnswerWhereWhoeverAsksWantsIt) {
  const Terminal terminal;
  auto client = SerialClient::open(terminal.path);
  ASSERT_TRUE(client);
  ASSERT_EQ(client->set_mode(kMode), std::nullopt);
  int asked = 0;
  const auto pieces =
      client->ask_all(SentRead(1, kRead), {kLong, kShort, kShort}, [&] { return ++asked == 2; });
  ASSERT_TRUE(pieces) << pieces.error();
  EXPECT_TRUE(pieces->empty());
  EXPECT_EQ(asked, 2);
}

TEST(SerialClient, TakesWhatLayThereBeforeItAsked) {
  const Terminal terminal;
  auto client = SerialClient::open(terminal.path);
  ASSERT_TRUE(client);
  ASSERT_EQ(client->set_mode(kMode), std::nullopt);
  const auto frame = data_of(2);
  ASSERT_EQ(::write(terminal.other_end(), frame.data(), frame.size()),
            static_cast<ssize_t>(frame.size()));
  const auto pieces =
      client->ask_all(SentRead(1, kRead), {std::chrono::milliseconds(100), kShort, kShort}, kGoOn);
  ASSERT_TRUE(pieces) << pieces.error();
  EXPECT_EQ(bytes_of(*pieces), frame);
}

TEST(SerialClient, OverhearsWithoutSending) {
  const Terminal terminal;
  auto client = SerialClient::open(terminal.path);
  ASSERT_TRUE(client);
  ASSERT_EQ(client->set_mode(kMode), std::nullopt);
  const auto silence = client->overhear(kShort);
  ASSERT_TRUE(silence);
  EXPECT_TRUE(silence->empty());
  const auto frame = data_of(1);
  ASSERT_EQ(::write(terminal.other_end(), frame.data(), frame.size()),
            static_cast<ssize_t>(frame.size()));
  const auto pieces = client->overhear(std::chrono::milliseconds(100));
  ASSERT_TRUE(pieces);
  EXPECT_EQ(bytes_of(*pieces), frame);
}

TEST(SerialClient, DoesNotOpenWhatIsNotThere) {
  const auto client = SerialClient::open("/dev/null");
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error(), ENOTTY);
}

}  // namespace
}  // namespace mbgate::ctl
