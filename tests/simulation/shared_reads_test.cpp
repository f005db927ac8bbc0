// SPDX-License-Identifier: Apache-2.0
// Many clients that poll the same registers: together they get many times what the wire carries,
// and nobody gets data older than the own request.
#include <cinttypes>

#include "simulation/polling.hpp"

namespace mbgate::test::shared_reads_test {
namespace {

constexpr unsigned kClients = 32;
constexpr std::uint16_t kCounter = kFirst;  // and the register behind it
constexpr Duration kMeasured = 4s;

struct Figures {
  std::uint64_t answers = 0;
  std::uint64_t exceptions = 0;
  std::uint64_t old = 0;  ///< sampled before they were asked for
  std::uint64_t transactions = 0;
  [[nodiscard]] double ratio() const {
    return static_cast<double>(answers) / static_cast<double>(transactions);
  }
};

std::uint64_t counter_in(const Answer& answer) {
  return std::uint64_t{modbus::load_be16(answer.pdu, 2)} << 16U | modbus::load_be16(answer.pdu, 4);
}

/// The clients think up to `longest` before they ask again. The drive's register holds the number
/// of the simulation's step: what it held when a request was sent is the least that may be in the
/// answer.
Figures measure(const BusPlan& plan, Duration longest, Duration cache = Duration{0}) {
  OneBus bus = one_bus(plan);
  drive::Device device;
  device.name = "drive";
  device.timing = plan.bus.timing;
  device.cache = cache;
  bus.settings.devices.push_back(device);
  Polling polling(bus.settings, bus.devices);
  auto& registers = polling.world().wire(0).device(1)->drive<sim::MoonsDrive>()->registers();
  polling.before_step([&registers](std::uint64_t step) {
    const std::array words{static_cast<std::uint16_t>(step >> 16U),
                           static_cast<std::uint16_t>(step & 0xFFFFU)};
    registers.write(kCounter, words);
  });
  std::mt19937 random{4};
  for (unsigned number = 0; number < kClients; ++number) {
    polling.add({.host = number,
                 .next =
                     [] {
                       return Registers{1, kCounter, 2};
                     },
                 .thinks =
                     [&random, longest] {
                       return Duration(static_cast<std::int64_t>(random()) % (longest.count() + 1));
                     }});
  }
  polling.run_for(1s);
  Figures figures;
  polling.on_answer([&figures](const Answer& answer) {
    if (answer.is_exception()) {
      ++figures.exceptions;
      return;
    }
    ++figures.answers;
    figures.old += counter_in(answer) <= answer.sent_in_step ? 1U : 0U;
  });
  const std::uint64_t before = polling.world().wire(0).counters().frames;
  polling.run_for(kMeasured);
  figures.transactions = polling.world().wire(0).counters().frames - before;
  return figures;
}

class SharedReads : public testing::TestWithParam<std::uint32_t> {};

TEST_P(SharedReads, GiveThirtyTwoClientsThirtyTimesTheWiresRate) {
  for (const Duration longest : {Duration{1us}, Duration{500us}, Duration{1500us}}) {
    const Figures figures = measure(bus_plan({1}, modbus::Baud{GetParam()}), longest);
    std::printf("%u baud, clients think up to %.1f ms: %" PRIu64 " answers, %" PRIu64
                " transactions: %.2f\n",
                GetParam(), std::chrono::duration<double, std::milli>(longest).count(),
                figures.answers, figures.transactions, figures.ratio());
    EXPECT_GE(figures.ratio(), 30.0);
    EXPECT_EQ(figures.old, 0U);
    EXPECT_EQ(figures.exceptions, 0U);
  }
}

// Clients that come back while a read is on the wire wait for the next one.
TEST_P(SharedReads, OfSlowerClientsAreNeverOlderThanTheirRequests) {
  for (const Duration longest : {Duration{5ms}, Duration{20ms}, Duration{100ms}}) {
    const Figures figures = measure(bus_plan({1}, modbus::Baud{GetParam()}), longest);
    std::printf("%u baud, clients think up to %.1f ms: %" PRIu64 " answers, %" PRIu64
                " transactions: %.2f\n",
                GetParam(), std::chrono::duration<double, std::milli>(longest).count(),
                figures.answers, figures.transactions, figures.ratio());
    EXPECT_GT(figures.answers, figures.transactions);
    EXPECT_EQ(figures.old, 0U);
    EXPECT_EQ(figures.exceptions, 0U);
  }
}

// A cache is asked for older data than the request, and this check can see it.
TEST_P(SharedReads, OfACacheAreOlder) {
  const Figures figures = measure(bus_plan({1}, modbus::Baud{GetParam()}), 5ms, 50ms);
  EXPECT_GT(figures.old, 0U);
}

INSTANTIATE_TEST_SUITE_P(Baud, SharedReads, testing::Values(9600U, 115200U),
                         [](const auto& tested) { return std::to_string(tested.param); });

}  // namespace
}  // namespace mbgate::test::shared_reads_test
