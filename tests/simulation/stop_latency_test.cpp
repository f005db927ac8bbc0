// SPDX-License-Identifier: Apache-2.0
// How soon a stop is on the wire after it was read, whatever the bus is doing just then, and that a
// move which waited for the same drive never runs. Every instant is exact.
#include <gtest/gtest.h>

#include <numeric>

#include "config/profiles/profile_file.hpp"
#include "simulation/plants.hpp"

namespace mbgate::test::stop_latency_test {
namespace {

constexpr std::uint16_t kOpcode = 0x007C;
constexpr std::uint8_t kDrives = 4;
constexpr std::uint8_t kDead = 5;
constexpr unsigned kClients = 16;  // with a pipeline of 16 each: 256 reads wait
constexpr unsigned kPipeline = 16;
constexpr Duration kStopWait = 100ms;
constexpr Duration kProcessing = 1ms;  // of the simulated drives
/// Between the instant of a byte and its delivery, as the wire has it.
constexpr Duration kDelivery = 1ms;

std::vector<std::uint8_t> opcode_pdu(std::uint8_t opcode) {
  return {0x06, kOpcode >> 8U, kOpcode & 0xFFU, 0, opcode};
}
constexpr std::uint8_t kStop = 0xE1;
constexpr std::uint8_t kMove = 0x66;  // feed to length

/// A bus with four live drives and a dead one, all of the same series.
class Stopping {
 public:
  explicit Stopping(std::uint32_t baud, std::uint16_t longest_read)
      : baud_(baud), longest_read_(longest_read), timing_(modbus::Baud{baud}, kFormat) {
    world_.emplace(settings(), devices(), [this](ClientId client, modbus::Bytes answer) {
      answers_[client].emplace_back(answer.begin() + 7, answer.end());
    });
    stopper_ = world_->connect(0, 100);
    mover_ = world_->connect(0, 101);
  }

  /// 256 reads of as many clients as that takes; they wait but for the first.
  void fill_queue() {
    for (unsigned number = 0; number < kClients; ++number) {
      const ClientId client = world_->connect(0, number);
      for (std::uint16_t at = 0; at < kPipeline; ++at) {
        const auto unit = static_cast<std::uint8_t>(1 + (number + at) % kDrives);
        const auto count = static_cast<std::uint16_t>(longest_read_ - (number + at) % 4);
        world_->send(client, adu(at, unit, read_pdu(kFirst, count)));
      }
    }
  }
  void read_dead() {
    const ClientId client = world_->connect(0, 99);
    world_->send(client, adu(1, kDead, read_pdu(kFirst, 1)));
  }
  void run_until(Instant instant) {
    world_->run(instant, [] { return false; });
  }
  /// Until the stop was answered, and a little longer.
  void run_until_stopped(Instant limit) {
    world_->run(limit, [this] { return answers_.contains(stopper_); });
    world_->run_for(200ms);
  }
  void move(std::uint8_t unit) { world_->send(mover_, adu(1, unit, opcode_pdu(kMove))); }
  void stop(std::uint8_t unit) { world_->send(stopper_, adu(1, unit, opcode_pdu(kStop))); }

  World& world() { return *world_; }
  [[nodiscard]] std::string move_answer() const { return answer_of(mover_); }
  [[nodiscard]] std::string stop_answer() const { return answer_of(stopper_); }
  [[nodiscard]] Duration t3_5() const { return timing_.t3_5(); }
  [[nodiscard]] Duration time_of(std::size_t bytes) const { return timing_.duration_of(bytes); }
  [[nodiscard]] Duration longest_response() const { return time_of(5U + 2U * longest_read_); }

  /// When the drive's answer to a frame begins and ends on the line.
  struct Times {
    Instant begin;
    Instant end;
  };
  [[nodiscard]] Times response_to(const sim::FrameOnWire& frame) const {
    const Instant begin = frame.end + t3_5() + kProcessing;
    const bool is_read = frame.bytes[1] == 0x03;
    return {begin, begin + time_of(is_read ? 5U + 2U * frame.bytes[5] : frame.bytes.size())};
  }
  [[nodiscard]] std::deque<sim::FrameOnWire> frames() { return world_->wire(0).frames(); }

  static bool is_opcode(const sim::FrameOnWire& frame, std::uint8_t opcode) {
    const auto pdu = opcode_pdu(opcode);
    return std::equal(pdu.begin(), pdu.end(), frame.bytes.begin() + 1,
                      frame.bytes.begin() + 1 + static_cast<std::ptrdiff_t>(pdu.size()));
  }

 private:
  static constexpr modbus::CharacterFormat kFormat{8, modbus::Parity::none, 1};

  [[nodiscard]] std::vector<std::vector<sim::DeviceSettings>> devices() const {
    auto plan = bus_plan({1, 2, 3, 4, kDead});
    plan.devices.back().faults.silent = true;
    for (auto& device : plan.devices) {
      device.series = sim::MoonsSeries::ssdc;
      device.processing = kProcessing;
    }
    return {plan.devices};
  }
  [[nodiscard]] gateway::Settings settings() const {
    gateway::Settings settings;
    settings.buses.push_back(bus_plan({}, modbus::Baud{baud_}).bus);
    settings.buses.front().timing.response_timeout = 1s;
    settings.buses.front().stop_wait = kStopWait;
    settings.buses.front().coalesce = false;  // each read waits for a turn of its own
    auto& listener = settings.listeners.emplace_back();
    listener.bus = BusId{0};
    const auto profile =
        config::load_profile(MBGATE_SOURCE_DIR "/conf/profiles/moons-ssdc.toml").file.value();
    for (std::uint8_t unit = 1; unit <= kDead; ++unit) {
      drive::Device device;
      device.name = "drive-" + std::to_string(unit);
      device.address = unit;
      device.profile = profile.profile;
      device.timing = settings.buses.front().timing;
      settings.devices.push_back(device);
    }
    return settings;
  }
  [[nodiscard]] std::string answer_of(ClientId client) const {
    const auto found = answers_.find(client);
    return found == answers_.end() ? "none" : modbus::hex(found->second.front());
  }

  std::uint32_t baud_;
  std::uint16_t longest_read_;
  modbus::RtuTiming timing_;
  std::optional<World> world_;
  std::map<ClientId, std::vector<std::vector<std::uint8_t>>> answers_;
  ClientId stopper_{};
  ClientId mover_{};
};

const char* const kCancelled = "86 06";
const char* const kEcho = "06 00 7C 00 E1";

double milliseconds(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// What a stop that was read at `read_at` met on the wire, and when it was there itself.
struct Seen {
  std::optional<sim::FrameOnWire> running;  ///< began last before the stop was read
  std::optional<sim::FrameOnWire> next;     ///< after it
  bool next_is_stop = false;
  bool moved = false;
};

Seen look(Stopping& plant, Instant read_at) {
  Seen seen;
  for (const auto& frame : plant.frames()) {
    const bool is_stop = Stopping::is_opcode(frame, kStop);
    if (frame.begin <= read_at && !is_stop) {
      seen.running = frame;
    } else if (!seen.next) {
      seen.next = frame;
      seen.next_is_stop = is_stop;
    }
    seen.moved = seen.moved || Stopping::is_opcode(frame, kMove);
  }
  return seen;
}

class StopLatency : public testing::TestWithParam<std::uint32_t> {};

// Reads of five registers, and of 44, whose responses take about 100 ms at 9600 baud. The stop
// comes in each third millisecond of two transactions.
TEST_P(StopLatency, BehindTwoHundredAndFiftySixReadsIsTheRestOfTheRunningTransaction) {
  Duration worst{0};
  unsigned tries = 0;
  for (const std::uint16_t registers : {std::uint16_t{5}, kRegisters}) {
    for (Duration offset{0};; offset += 3ms) {
      Stopping plant(GetParam(), registers);
      plant.fill_queue();
      const Duration transaction =
          plant.time_of(8) + 2 * plant.t3_5() + kProcessing + plant.longest_response();
      if (offset > 2 * transaction) {
        break;
      }
      const Instant read_at = plant.world().now() + 3 * transaction + offset;
      plant.run_until(read_at);
      plant.move(2);
      plant.stop(2);
      plant.run_until_stopped(read_at + 20s);
      const Seen seen = look(plant, read_at);
      ASSERT_TRUE(seen.running) << milliseconds(offset);
      ASSERT_TRUE(seen.next_is_stop) << "another frame went before it, " << milliseconds(offset);
      const auto response = plant.response_to(*seen.running);
      const Instant allowed =
          std::max(read_at, response.end + plant.t3_5() + kDelivery);  // it began in time
      ASSERT_LE(response.begin, read_at + kStopWait);
      EXPECT_LE(seen.next->begin, allowed) << milliseconds(offset);
      EXPECT_FALSE(seen.moved);
      EXPECT_EQ(plant.move_answer(), kCancelled);
      EXPECT_EQ(plant.stop_answer(), kEcho);
      EXPECT_EQ(plant.world().silence_violations(), 0U);
      EXPECT_EQ(plant.world().collisions(), 0U);
      worst = std::max(worst, seen.next->begin - read_at);
      ++tries;
    }
  }
  std::printf("%u baud, 256 reads waiting: %u stops, the latest on the wire after %.2f ms\n",
              GetParam(), tries, milliseconds(worst));
}

/// Every third millisecond where something begins or ends, and now and then between.
Duration next_offset(Duration offset) {
  return offset + (offset < 30ms || offset >= 980ms ? 3ms : 50ms);
}

// The stop comes between the beginning of the request and the end of the timeout of 1 s, for the
// dead drive itself or for another one.
TEST_P(StopLatency, BehindADeadDriveIsStopWait) {
  Duration worst{0};
  unsigned tries = 0;
  for (const std::uint8_t unit : {std::uint8_t{1}, kDead}) {
    for (Duration offset = 1ms; offset < 1010ms; offset = next_offset(offset)) {
      Stopping plant(GetParam(), 5);
      plant.read_dead();
      const Instant begun = plant.world().now();
      plant.fill_queue();
      plant.run_until(begun + plant.t3_5() + offset);
      const Instant read_at = plant.world().now();
      plant.move(unit);
      plant.stop(unit);
      plant.run_until_stopped(read_at + 20s);
      const Seen seen = look(plant, read_at);
      ASSERT_TRUE(seen.running) << milliseconds(offset);
      ASSERT_TRUE(seen.next_is_stop) << "another frame went before it, " << milliseconds(offset);
      const Instant allowed = std::max(read_at + kDelivery, seen.running->end + kStopWait);
      EXPECT_LE(seen.next->begin, allowed) << milliseconds(offset) << " unit " << unsigned{unit};
      EXPECT_FALSE(seen.moved);
      EXPECT_EQ(plant.move_answer(), kCancelled);
      EXPECT_EQ(plant.stop_answer(), unit == kDead ? "86 0B" : kEcho);
      EXPECT_EQ(plant.world().silence_violations(), 0U);
      EXPECT_EQ(plant.world().collisions(), 0U);
      worst = std::max(worst, seen.next->begin - read_at);
      ++tries;
    }
  }
  std::printf("%u baud, a dead drive: %u stops, the latest on the wire after %.2f ms\n", GetParam(),
              tries, milliseconds(worst));
}

INSTANTIATE_TEST_SUITE_P(Baud, StopLatency, testing::Values(9600U, 115200U),
                         [](const auto& tested) { return std::to_string(tested.param); });

}  // namespace
}  // namespace mbgate::test::stop_latency_test
