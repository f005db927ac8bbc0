// SPDX-License-Identifier: Apache-2.0
#include "soak/registers.hpp"

#include "soak/specification.hpp"

namespace mbgate::soak {
namespace {

// Finalizer of the SplitMix64 generator: every bit of the input moves every bit of the output.
std::uint64_t mixed(std::uint64_t value) {
  value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9U;
  value = (value ^ (value >> 27U)) * 0x94D049BB133111EBU;
  return value ^ (value >> 31U);
}

std::uint64_t ticks(Instant at) {
  return static_cast<std::uint64_t>(at.time_since_epoch() / std::chrono::milliseconds(1));
}

std::uint16_t word(std::uint64_t value) { return static_cast<std::uint16_t>(value & 0xFFFFU); }

std::uint16_t half(std::uint32_t words, unsigned address) {
  return word((address & 1U) == 0 ? words >> 16U : words);
}

}  // namespace

bool is_slow(modbus::Bytes request) {
  const auto reaches = [&](std::size_t field, bool one) {
    const unsigned count = one ? 1 : spec::word_at(request, field + 2);
    const unsigned first = spec::word_at(request, field);
    return first < kSlowEnd && first + count > kSlowFrom;
  };
  switch (request[0]) {
    case 0x06:
    case 0x16: return reaches(1, true);
    case 0x03:
    case 0x10: return reaches(1, false);
    case 0x17: return reaches(1, false) || reaches(5, false);
    default: return false;
  }
}

Registers::Registers(std::uint64_t salt) : salt_(salt) {
  for (unsigned address = 0; address < kRegisters; ++address) {
    const std::uint32_t first = this->salt(Table::holding_registers, address);
    const std::uint32_t second = this->salt(Table::holding_registers, address + 1000);
    histories_.at(address).push_back({Instant::min(), (first << 16U) | second});
    if (!is_in_pair(Table::holding_registers, address)) {
      histories_.at(address).back().words = first;
    }
  }
}

std::uint16_t Registers::salt(Table table, unsigned address) const {
  return word(mixed(salt_ + (static_cast<std::uint64_t>(table) << 32U) + address));
}

const Registers::History* Registers::written_bit(Table table, unsigned address) const {
  const auto found = coils_.find(address);
  return table != Table::coils || found == coils_.end() ? nullptr : &found->second;
}

std::uint16_t Registers::read(Table table, unsigned address, Instant at) const {
  if (table == Table::coils || table == Table::discrete_inputs) {
    const History* written = written_bit(table, address);
    return written != nullptr ? word(written->back().words) : salt(table, address) & 1U;
  }
  if (is_live(table, address)) {
    return word(salt(table, address) + ticks(at));
  }
  const std::uint32_t words = history(address).back().words;
  return is_in_pair(table, address) ? half(words, address) : word(words);
}

void Registers::write(unsigned address, std::uint16_t value, Instant at) {
  std::uint32_t words = value;
  if (is_in_pair(Table::holding_registers, address)) {
    const std::uint32_t before = history(address).back().words;
    words =
        (address & 1U) == 0 ? (before & 0xFFFFU) | (words << 16U) : (before & 0xFFFF0000U) | words;
    address = pair_of(address);
  }
  histories_.at(address).push_back({at, words});
}

void Registers::write_pair(unsigned first, std::uint32_t words, Instant at) {
  histories_.at(first).push_back({at, words});
}

void Registers::write_coil(unsigned address, bool value, Instant at) {
  History& history = coils_[address];
  if (history.empty()) {
    history.push_back({Instant::min(), salt(Table::coils, address) & 1U});
  }
  history.push_back({at, value ? 1U : 0U});
}

template <typename Fits>
bool Registers::any(const History& history, Span span, Fits fits) {
  for (auto version = history.rbegin(); version != history.rend(); ++version) {
    if (version->since <= span.last && fits(version->words)) {
      return true;
    }
    if (version->since <= span.first) {
      return false;
    }
  }
  return false;
}

bool Registers::held(Table table, unsigned address, std::uint16_t value, Span span) const {
  if (table == Table::coils || table == Table::discrete_inputs) {
    const History* written = written_bit(table, address);
    return written != nullptr ? any(*written, span, [&](auto bit) { return bit == value; })
                              : value == (salt(table, address) & 1U);
  }
  if (is_live(table, address)) {
    const std::uint64_t first = ticks(span.first);
    return word(value - salt(table, address) - first) <= ticks(span.last) - first;
  }
  return any(history(address), span, [&](std::uint32_t words) {
    return value == (is_in_pair(table, address) ? half(words, address) : word(words));
  });
}

bool Registers::low_held(Table table, unsigned address, std::uint8_t value, Span span) const {
  constexpr unsigned kHighBytes = 256;
  for (unsigned upper = 0; upper < kHighBytes; ++upper) {
    if (held(table, address, static_cast<std::uint16_t>(upper * kHighBytes + value), span)) {
      return true;
    }
  }
  return false;
}

bool Registers::pair_held(unsigned first, std::uint32_t words, Span span) const {
  return any(histories_.at(first), span, [&](std::uint32_t held) { return held == words; });
}

}  // namespace mbgate::soak
