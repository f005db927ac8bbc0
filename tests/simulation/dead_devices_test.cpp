// SPDX-License-Identifier: Apache-2.0
// Nobody waits for the dead: throughput and latency of the live devices of a bus while others of it
// are silent, against the same bus without these.
#include <set>

#include "simulation/polling.hpp"

namespace mbgate::test {
namespace {

constexpr std::uint8_t kDevices = 8;
constexpr Duration kResponseTimeout = 100ms;
constexpr Duration kWarmUp = 10s;  // the breakers open, and the first probes are over
constexpr Duration kMeasured = 20s;
constexpr double kSeconds = std::chrono::duration<double>(kMeasured).count();
constexpr Duration kThinks = 2ms;  // little against a round of the bus

struct Figures {
  std::uint64_t answers = 0;
  std::uint64_t wrong = 0;
  std::uint64_t exceptions = 0;                    // of live devices
  std::map<std::uint8_t, std::uint64_t> refusals;  // of dead devices, by exception code
  std::vector<Duration> latencies{};
  [[nodiscard]] Duration percentile(std::size_t percent) {
    std::ranges::sort(latencies);
    return latencies.empty() ? Duration{0} : latencies[(latencies.size() - 1) * percent / 100];
  }
};

/// Who asks for what.
enum class Clients : std::uint8_t {
  one_a_device,  ///< eight clients with a device each
  everywhere     ///< four clients that ask all devices in turn
};

class DeadDevices : public testing::TestWithParam<std::tuple<unsigned, Clients>> {
 protected:
  /// `dead` of the addresses are silent; without `present` nobody asks for them, either.
  static Figures measure(unsigned dead, bool present, Clients clients) {
    BusPlan plan = bus_plan({1, 2, 3, 4, 5, 6, 7, 8});
    plan.bus.timing.response_timeout = kResponseTimeout;
    std::set<std::uint8_t> silent;
    for (unsigned at = 0; at < dead; ++at) {
      silent.insert(static_cast<std::uint8_t>(2 * at + 1));  // among the others
    }
    for (auto& device : plan.devices) {
      device.faults.silent = silent.contains(device.address);
    }
    const OneBus bus = one_bus(plan);
    Polling polling(bus.settings, bus.devices);
    fill_drives(polling.world());
    std::vector<std::uint8_t> asked;
    for (std::uint8_t unit = 1; unit <= kDevices; ++unit) {
      if (present || !silent.contains(unit)) {
        asked.push_back(unit);
      }
    }
    add_clients(polling, clients, asked);
    polling.run_for(kWarmUp);
    Figures figures;
    polling.on_answer([&](const Answer& answer) { count(answer, silent, figures); });
    polling.run_for(kMeasured);
    EXPECT_EQ(polling.world().silence_violations(), 0U);
    EXPECT_EQ(polling.world().collisions(), 0U);
    return figures;
  }

 private:
  static void add_clients(Polling& polling, Clients clients,
                          const std::vector<std::uint8_t>& asked) {
    if (clients == Clients::one_a_device) {
      for (const std::uint8_t unit : asked) {
        polling.add({.host = unit,
                     .next =
                         [unit] {
                           return Registers{unit, kFirst, 4};
                         },
                     .thinks = [] { return kThinks; }});
      }
      return;
    }
    for (unsigned number = 0; number < 4; ++number) {
      const auto first = static_cast<std::uint16_t>(kFirst + number * 4);
      polling.add({.host = number,
                   .next =
                       [asked, first, turn = number]() mutable {
                         return Registers{asked[turn++ % asked.size()], first, 4};
                       },
                   .thinks = [] { return kThinks; }});
    }
  }
  static void count(const Answer& answer, const std::set<std::uint8_t>& silent, Figures& figures) {
    if (silent.contains(answer.asked.unit)) {
      ++figures.refusals[answer.is_exception() ? answer.pdu[1] : std::uint8_t{0}];
    } else if (answer.is_exception()) {
      ++figures.exceptions;
    } else {
      figures.wrong += is_right(answer) ? 0U : 1U;
      ++figures.answers;
      figures.latencies.push_back(answer.latency());
    }
  }
};

double milliseconds(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

TEST_P(DeadDevices, CostTheLiveOnesNextToNothing) {
  const auto [dead, clients] = GetParam();
  Figures without = measure(dead, false, clients);
  Figures with = measure(dead, true, clients);
  const double ratio = static_cast<double>(with.answers) / static_cast<double>(without.answers);
  const Duration p99 = with.percentile(99);
  const Duration p99_without = without.percentile(99);
  std::printf(
      "%u of %u dead: %.1f reads/s of the live ones, %.1f without the dead: %.2f %%; p99 %.1f ms, "
      "%.1f ms without, worst %.1f ms, %.1f ms without\n",
      dead, unsigned{kDevices}, static_cast<double>(with.answers) / kSeconds,
      static_cast<double>(without.answers) / kSeconds, 100.0 * ratio, milliseconds(p99),
      milliseconds(p99_without), milliseconds(with.percentile(100)),
      milliseconds(without.percentile(100)));
  EXPECT_GE(ratio, 0.97);
  EXPECT_LE(p99, p99_without * 3 / 2 + kResponseTimeout);
  EXPECT_EQ(with.wrong, 0U);
  EXPECT_EQ(with.exceptions, 0U);
  EXPECT_EQ(with.refusals.size(), 1U);
  EXPECT_GT(with.refusals[0x0B], 0U);
}

INSTANTIATE_TEST_SUITE_P(OneTwoFour, DeadDevices,
                         testing::Combine(testing::Values(1U, 2U, 4U),
                                          testing::Values(Clients::one_a_device,
                                                          Clients::everywhere)),
                         [](const auto& tested) {
                           return std::to_string(std::get<0>(tested.param)) +
                                  (std::get<1>(tested.param) == Clients::everywhere ? "AskedByAll"
                                                                                    : "AskedByOne");
                         });

}  // namespace
}  // namespace mbgate::test
