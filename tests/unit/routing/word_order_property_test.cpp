// SPDX-License-Identifier: Apache-2.0
// Over random drives and requests: what a client writes in its order it reads back, and the drive
// holds it in its own.
#include <array>
#include <random>

#include "device_rig.hpp"
#include "modbus/response.hpp"

namespace mbgate::test {
namespace {

constexpr std::uint16_t kRegisters = 160;
using Memory = std::array<std::uint16_t, kRegisters>;

class RandomDrive {
 public:
  explicit RandomDrive(std::uint32_t seed) : random_(seed) {
    device.word_order = chance(2) ? WordOrder::little : WordOrder::big;
    for (std::uint16_t at = 0; at + 4 <= kRegisters;) {
      if (chance(3)) {
        const auto registers = static_cast<std::uint8_t>(chance(4) ? 4 : 2);
        device.profile.values.add({Table::holding_registers, at, registers, chance(6)});
        at = static_cast<std::uint16_t>(at + registers);
      } else {
        ++at;
      }
    }
    device.profile.limits.read[2] = static_cast<std::uint16_t>(between(4, 125));
    device.profile.limits.write_registers = static_cast<std::uint16_t>(between(4, 123));
    device.split_writes = chance(2);
    device.split_values = chance(2);
    device.write_function =
        chance(3) ? std::optional<std::uint8_t>(chance(2) ? 6 : 16) : std::optional<std::uint8_t>();
    add_groups();
    std::ranges::generate(holds, [this] { return word(); });
  }

  bool chance(int one_in) { return between(1, one_in) == 1; }
  int between(int low, int high) { return std::uniform_int_distribution(low, high)(random_); }
  std::uint16_t word() { return static_cast<std::uint16_t>(between(0, 0xFFFF)); }

  /// What a client sees that wants `order`: value by value, written out for this test alone.
  [[nodiscard]] Memory seen_in(WordOrder order) const {
    Memory seen = holds;
    if (order != *device.word_order) {
      for (const auto& value : device.profile.values.all()) {
        for (std::size_t word = 0; word < value.registers; ++word) {
          seen.at(value.first + word) = holds.at(value.first + value.registers - 1U - word);
        }
      }
    }
    return seen;
  }

  /// Carries a request out as the drive would, and holds it against the drive's limits.
  modbus::Pdu carry_out(const modbus::Request& request) {
    const auto bytes = request.pdu().bytes();
    std::vector<std::uint8_t> response(bytes.begin(), bytes.begin() + 1);
    if (const auto& writes = request.writes()) {
      check_fit(writes->range, device.profile.limits.write_registers);
      for (std::uint16_t at = 0; at < writes->range.count; ++at) {
        auto& held = holds.at(writes->range.first + std::size_t{at});
        const auto address = static_cast<std::uint16_t>(writes->range.first + at);
        held = request.function() == 0x16
                   ? static_cast<std::uint16_t>(
                         (held & modbus::load_be16(bytes, 3)) |
                         (modbus::load_be16(bytes, 5) & ~modbus::load_be16(bytes, 3)))
                   : request.written(address).value();
      }
      if (!request.reads()) {
        return modbus::echo_response(request);
      }
    }
    const auto& range = request.reads()->range;
    check_fit(range, device.profile.limits.read[2]);
    response.push_back(static_cast<std::uint8_t>(range.count * 2));
    for (std::uint16_t at = 0; at < range.count; ++at) {
      const auto held = holds.at(range.first + std::size_t{at});
      response.push_back(static_cast<std::uint8_t>(held >> 8U));
      response.push_back(static_cast<std::uint8_t>(held & 0xFFU));
    }
    return *modbus::Pdu::from(response);
  }

  drive::Device device;
  Memory holds{};

 private:
  void add_groups() {
    std::uint16_t begin = 0;
    while (begin < kRegisters && chance(2)) {
      auto end = static_cast<std::uint16_t>(std::min<int>(begin + between(8, 60), kRegisters));
      const auto* value = device.profile.values.at(Table::holding_registers, end);
      end = value != nullptr ? value->first : end;
      device.profile.groups.push_back(
          {Table::holding_registers, begin, static_cast<std::uint16_t>(end - begin)});
      begin = end;
    }
  }
  void check_fit(const modbus::TableRange& range, std::uint16_t limit) const {
    EXPECT_LE(range.count, limit);
    EXPECT_GE(device.profile.group_end(range.table, range.first), drive::end_of(range));
  }

  std::mt19937 random_;
};

std::string random_request(RandomDrive& drive) {
  const std::array<std::uint8_t, 5> functions{0x03, 0x06, 0x10, 0x16, 0x17};
  const auto function = functions.at(static_cast<std::size_t>(drive.between(0, 4)));
  std::vector<std::uint8_t> bytes{function};
  const auto add16 = [&](int word) {
    bytes.push_back(static_cast<std::uint8_t>(word >> 8));
    bytes.push_back(static_cast<std::uint8_t>(word & 0xFF));
  };
  const auto add_range = [&](int most) {
    const int count = drive.between(1, drive.chance(2) ? std::min(most, 4) : most);
    add16(drive.between(0, kRegisters - count));
    add16(count);
    return count;
  };
  const auto add_words = [&](int count) {
    bytes.push_back(static_cast<std::uint8_t>(count * 2));
    for (int word = 0; word < count; ++word) {
      add16(drive.word());
    }
  };
  switch (function) {
    case 0x03: add_range(125); break;
    case 0x10: add_words(add_range(123)); break;
    case 0x17:
      add_range(125);
      add_words(add_range(121));
      break;
    default:
      add16(drive.between(0, kRegisters - 1));
      add16(drive.word());
      if (function == 0x16) {
        add16(drive.word());
      }
  }
  return hex(bytes);
}

/// What the request does to the client's own picture of the drive.
void expect_in(Memory& seen, const modbus::Request& request) {
  const auto bytes = request.pdu().bytes();
  if (!request.writes()) {
    return;
  }
  for (std::uint16_t at = 0; at < request.writes()->range.count; ++at) {
    const auto address = static_cast<std::uint16_t>(request.writes()->range.first + at);
    const auto mask = modbus::load_be16(bytes, 3);
    seen.at(address) = request.function() == 0x16
                           ? static_cast<std::uint16_t>((seen.at(address) & mask) |
                                                        (modbus::load_be16(bytes, 5) & ~mask))
                           : request.written(address).value();
  }
}

void check_answer(const modbus::Request& request, const modbus::Pdu& answer, const Memory& seen) {
  ASSERT_EQ(modbus::check_response(request, answer.bytes()), modbus::ResponseFit::normal);
  if (!request.reads()) {
    return;
  }
  const auto& range = request.reads()->range;
  for (std::uint16_t at = 0; at < range.count; ++at) {
    ASSERT_EQ(modbus::load_be16(answer.bytes(), 2 + std::size_t{at} * 2),
              seen.at(range.first + std::size_t{at}));
  }
}

TEST(WordOrderProperty, WhatAClientWritesItReadsBackAndTheDriveHoldsInItsOwnOrder) {
  unsigned carried_out = 0;
  unsigned refused = 0;
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    RandomDrive drive(seed);
    const auto order = seed % 2 == 0 ? WordOrder::big : WordOrder::little;
    Memory seen = drive.seen_in(order);
    for (int step = 0; step < 50; ++step) {
      const std::string text = random_request(drive);
      SCOPED_TRACE(testing::Message() << "seed " << seed << " step " << step << ": " << text);
      const auto request = modbus::Request::parse(pdu(text));
      ASSERT_TRUE(request);
      const Planned planned(drive.device, text, order);
      if (!planned.plan) {
        ASSERT_EQ(planned.requests(), Texts{kIllegalValue});
        ++refused;
        continue;
      }
      std::vector<modbus::Pdu> responses;
      for (const auto& transaction : planned.plan->transactions()) {
        responses.push_back(drive.carry_out(transaction.request));
      }
      expect_in(seen, *request);
      check_answer(*request, answer_of(*planned.plan, responses), seen);
      ASSERT_EQ(drive.seen_in(order), seen);
      ++carried_out;
    }
  }
  EXPECT_GT(carried_out, 5000U);
  EXPECT_GT(refused, 1000U);
}

}  // namespace
}  // namespace mbgate::test
