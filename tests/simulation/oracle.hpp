// SPDX-License-Identifier: Apache-2.0
// Clients that know what they asked: each request has exactly one answer, of its own transaction
// and unit, with the data that belongs to it.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <vector>

#include "modbus/describe.hpp"
#include "simulation/world.hpp"

namespace mbgate::test {

/// What every register of the test's drives holds, so that an answer tells where it came from.
inline std::uint16_t value_of(std::uint8_t unit, std::uint16_t address) {
  return static_cast<std::uint16_t>(unit * 1000 + address * 7);
}

inline std::vector<std::uint8_t> adu(std::uint16_t transaction, std::uint8_t unit,
                                     const std::vector<std::uint8_t>& pdu) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(7 + pdu.size());
  bytes.push_back(static_cast<std::uint8_t>(transaction >> 8U));
  bytes.push_back(static_cast<std::uint8_t>(transaction & 0xFFU));
  bytes.resize(5);
  bytes.push_back(static_cast<std::uint8_t>(pdu.size() + 1));
  bytes.push_back(unit);
  bytes.insert(bytes.end(), pdu.begin(), pdu.end());
  return bytes;
}

/// Reads `count` registers.
inline std::vector<std::uint8_t> read_pdu(std::uint16_t address, std::uint16_t count) {
  return {0x03, static_cast<std::uint8_t>(address >> 8U),
          static_cast<std::uint8_t>(address & 0xFFU), 0, static_cast<std::uint8_t>(count)};
}

/// Writes the values that belong to the registers.
inline std::vector<std::uint8_t> write_pdu(std::uint8_t unit, std::uint16_t address,
                                           std::uint16_t count) {
  std::vector<std::uint8_t> pdu{
      0x10, static_cast<std::uint8_t>(address >> 8U), static_cast<std::uint8_t>(address & 0xFFU),
      0,    static_cast<std::uint8_t>(count),         static_cast<std::uint8_t>(count * 2)};
  for (unsigned at = 0; at < count; ++at) {
    const std::uint16_t value = value_of(unit, static_cast<std::uint16_t>(address + at));
    pdu.push_back(static_cast<std::uint8_t>(value >> 8U));
    pdu.push_back(static_cast<std::uint8_t>(value & 0xFFU));
  }
  return pdu;
}

inline std::vector<std::uint8_t> data_pdu(std::uint8_t unit, std::uint16_t address,
                                          std::uint16_t count) {
  std::vector<std::uint8_t> pdu{0x03, static_cast<std::uint8_t>(count * 2)};
  for (unsigned at = 0; at < count; ++at) {
    const std::uint16_t value = value_of(unit, static_cast<std::uint16_t>(address + at));
    pdu.push_back(static_cast<std::uint8_t>(value >> 8U));
    pdu.push_back(static_cast<std::uint8_t>(value & 0xFFU));
  }
  return pdu;
}

class Oracle {
 public:
  /// The request was sent; its answer must be `expected`, or an exception if `may_fail`.
  void expect(ClientId client, std::uint16_t transaction, std::vector<std::uint8_t> expected,
              bool may_fail = false) {
    const bool is_new =
        open_[client].emplace(transaction, Expected{std::move(expected), may_fail}).second;
    EXPECT_TRUE(is_new) << "the test used transaction " << transaction << " twice";
  }
  void take(ClientId client, modbus::Bytes answer) {
    ASSERT_FALSE(gone_.contains(client)) << "an answer for a client that is gone";
    const std::uint16_t transaction = modbus::load_be16(answer, 0);
    auto& open = open_[client];
    const auto found = open.find(transaction);
    ASSERT_NE(found, open.end()) << "not asked, or answered twice: " << modbus::hex(answer);
    const auto& expected = found->second;
    const bool exception = (answer[7] & 0x80U) != 0;
    if (exception && expected.may_fail) {
      ++exceptions_[answer[8]];
    } else {
      EXPECT_EQ(modbus::hex(answer), modbus::hex(expected.adu));
      ++answered_;
    }
    open.erase(found);
  }
  void forget(ClientId client) {
    open_.erase(client);
    gone_.insert(client);
  }
  [[nodiscard]] std::size_t open() const {
    std::size_t total = 0;
    for (const auto& [client, requests] : open_) {
      total += requests.size();
    }
    return total;
  }
  [[nodiscard]] std::size_t open_of(ClientId client) const {
    const auto found = open_.find(client);
    return found == open_.end() ? 0 : found->second.size();
  }
  [[nodiscard]] std::uint64_t answered() const { return answered_; }
  [[nodiscard]] const std::map<std::uint8_t, std::uint64_t>& exceptions() const {
    return exceptions_;
  }

 private:
  struct Expected {
    std::vector<std::uint8_t> adu;
    bool may_fail;
  };
  std::map<ClientId, std::map<std::uint16_t, Expected>> open_;
  std::set<ClientId> gone_;
  std::uint64_t answered_ = 0;
  std::map<std::uint8_t, std::uint64_t> exceptions_;
};

}  // namespace mbgate::test
