// SPDX-License-Identifier: Apache-2.0
// Client addresses share a bus equally, or by their weights, however much each of them asks.
#include <cinttypes>

#include "simulation/polling.hpp"

namespace mbgate::test::fairness_test {
namespace {

constexpr unsigned kClients = 32;
constexpr std::size_t kGreedy = 200;
constexpr Duration kMeasured = 20s;

class Fairness : public testing::TestWithParam<bool> {
 protected:
  /// Client 0 has 200 reads outstanding, 31 others one each.
  static OneBus plant(bool coalesce) {
    BusPlan plan = bus_plan({1, 2, 3, 4});
    plan.bus.coalesce = coalesce;
    OneBus bus = one_bus(plan);
    bus.settings.listeners.front().pipeline = kGreedy;
    return bus;
  }
  /// What the clients got within the time measured, by number.
  static std::vector<std::uint64_t> measure(const OneBus& bus) {
    Polling polling(bus.settings, bus.devices);
    fill_drives(polling.world());
    for (unsigned number = 0; number < kClients; ++number) {
      polling.add({.host = number,
                   .outstanding = number == 0 ? kGreedy : 1,
                   .next = [number, turn = number]() mutable { return ask(number, turn++); }});
    }
    polling.run_for(10s);
    std::vector<std::uint64_t> got(kClients);
    std::uint64_t wrong = 0;
    polling.on_answer([&](const Answer& answer) {
      if (!answer.is_exception()) {
        ++got[answer.poller];
        wrong += is_right(answer) ? 0U : 1U;
      }
    });
    polling.run_for(kMeasured);
    EXPECT_EQ(wrong, 0U);
    EXPECT_EQ(polling.world().silence_violations(), 0U);
    return got;
  }
  static double sum(const std::vector<std::uint64_t>& got) {
    double total = 0;
    for (const std::uint64_t count : got) {
      total += static_cast<double>(count);
    }
    return total;
  }

 private:
  /// No two clients ask for the same; the greedy one asks for single registers.
  static Registers ask(unsigned number, unsigned turn) {
    const auto unit = static_cast<std::uint8_t>(1 + turn % 4);
    if (number == 0) {
      return {unit, static_cast<std::uint16_t>(kFirst + turn / 4 % kRegisters), 1};
    }
    return {unit, static_cast<std::uint16_t>(kFirst + number), 2};
  }
};

TEST_P(Fairness, AClientWithTwoHundredRequestsGetsNoMoreThanOneWithOne) {
  const bool coalesce = GetParam();
  const auto got = measure(plant(coalesce));
  const double total = sum(got);
  // Of the greedy client's reads identical ones share a transmission; what counts are turns.
  const double others = total - static_cast<double>(got[0]);
  const double fair = coalesce ? others / (kClients - 1) : total / kClients;
  const auto [least, most] = std::minmax_element(got.begin() + 1, got.end());
  std::printf("fair %.1f reads; the 31 got %" PRIu64 " to %" PRIu64
              " (%.2f to %.2f of that), the greedy one %" PRIu64 "\n",
              fair, *least, *most, static_cast<double>(*least) / fair,
              static_cast<double>(*most) / fair, got[0]);
  EXPECT_GE(static_cast<double>(*least), 0.98 * fair);
  EXPECT_LE(static_cast<double>(*most), 1.02 * fair);
  if (!coalesce) {
    EXPECT_LE(static_cast<double>(got[0]), 1.02 * fair);
  }
}

// Client 0 gets four turns where the others get one, because it always has as many waiting.
TEST_P(Fairness, AClientOfWeightFourGetsFourTimesAsMuch) {
  OneBus bus = plant(GetParam());
  bus.settings.weights.push_back({*routing::Network::parse("10.0.0.1/32"), 4});
  const auto got = measure(bus);
  const double turn = sum(got) / (kClients + 3);
  const auto [least, most] = std::minmax_element(got.begin() + 1, got.end());
  std::printf("of weight 4: %.2f turns; of weight 1: %.2f to %.2f\n",
              static_cast<double>(got[0]) / turn, static_cast<double>(*least) / turn,
              static_cast<double>(*most) / turn);
  EXPECT_NEAR(static_cast<double>(got[0]) / turn, 4.0, 0.1);
  EXPECT_GE(static_cast<double>(*least), 0.98 * turn);
  EXPECT_LE(static_cast<double>(*most), 1.02 * turn);
}

INSTANTIATE_TEST_SUITE_P(SharedAndNot, Fairness, testing::Bool(), [](const auto& tested) {
  return std::string(tested.param ? "Coalescing" : "OneTransmissionEach");
});

}  // namespace
}  // namespace mbgate::test::fairness_test
