// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/register_bank.hpp"

#include <algorithm>

namespace mbgate::sim {
namespace {

std::size_t registers_of(Width width) { return static_cast<std::size_t>(width); }

bool within(const RegisterRun& run, std::uint32_t value) {
  if (!run.limits) {
    return true;
  }
  std::int64_t number = value;
  if (run.limits->lowest < 0) {
    number = run.width == Width::word ? std::int64_t{static_cast<std::int16_t>(value)}
                                      : std::int64_t{static_cast<std::int32_t>(value)};
  }
  return number >= run.limits->lowest && number <= run.limits->highest;
}

}  // namespace

RegisterBank::RegisterBank(RegisterMap map, drive::WordOrder order)
    : runs_(map.begin(), map.end()), order_(order) {
  for (const RegisterRun& run : runs_) {
    offsets_.push_back(values_.size());
    values_.resize(values_.size() + run.entries);
  }
  restore_initial();
}

Result<Registers, Refusal> RegisterBank::read(std::uint16_t first, std::uint16_t count) const {
  Registers words;
  for (std::uint32_t address = first; address < std::uint32_t{first} + count; ++address) {
    const auto place = find(address);
    if (!place) {
      return Refusal::no_such_register;
    }
    if (place->run->access == Access::write_only) {
      return Refusal::not_readable;
    }
    words.push_back(word_of(*place));
  }
  return words;
}

std::optional<Refusal> RegisterBank::write(std::uint16_t first,
                                           std::span<const std::uint16_t> words) {
  Changes changes;
  if (const auto refusal = collect(first, words, changes)) {
    return refusal;
  }
  for (const Change& change : changes) {
    if (!within(*change.place.run, change.value)) {
      return Refusal::out_of_range;
    }
  }
  for (const Change& change : changes) {
    values_[change.place.entry] = change.value;
  }
  return std::nullopt;
}

std::optional<Refusal> RegisterBank::collect(std::uint16_t first,
                                             std::span<const std::uint16_t> words,
                                             Changes& changes) const {
  std::uint32_t address = first;
  for (const std::uint16_t word : words) {
    const auto place = find(address++);
    if (!place) {
      return Refusal::no_such_register;
    }
    if (place->run->access == Access::read_only) {
      return Refusal::not_writable;
    }
    if (changes.empty() || changes.back().place.entry != place->entry) {
      changes.push_back({*place, values_[place->entry]});
    }
    changes.back().value = with_word(*place, changes.back().value, word);
  }
  return std::nullopt;
}

std::uint32_t RegisterBank::get(std::uint16_t address) const {
  return values_[find(address)->entry];
}

void RegisterBank::set(std::uint16_t address, std::uint32_t value) {
  const Place place = *find(address);
  values_[place.entry] = place.run->width == Width::word ? value & 0xFFFFU : value;
}

void RegisterBank::restore_initial() {
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    for (std::uint32_t entry = 0; entry < runs_[i].entries; ++entry) {
      values_[offsets_[i] + entry] = runs_[i].initial + entry * runs_[i].step;
    }
  }
}

std::optional<RegisterBank::Place> RegisterBank::find(std::uint32_t address) const {
  const auto after = std::ranges::upper_bound(runs_, address, {}, &RegisterRun::first);
  if (after == runs_.begin()) {
    return std::nullopt;
  }
  const RegisterRun& run = *std::prev(after);
  const std::size_t distance = address - run.first;
  const std::size_t entry = distance / registers_of(run.width);
  if (entry >= run.entries) {
    return std::nullopt;
  }
  const std::size_t offset = offsets_[static_cast<std::size_t>(&run - runs_.data())];
  return Place{&run, offset + entry, distance % registers_of(run.width)};
}

std::uint16_t RegisterBank::word_of(const Place& place) const {
  const std::uint32_t value = values_[place.entry];
  if (place.run->width == Width::word) {
    return static_cast<std::uint16_t>(value);
  }
  return drive::to_registers(value, order_)[place.half];
}

std::uint32_t RegisterBank::with_word(const Place& place, std::uint32_t value,
                                      std::uint16_t word) const {
  if (place.run->width == Width::word) {
    return word;
  }
  auto registers = drive::to_registers(value, order_);
  registers[place.half] = word;
  return drive::from_registers(registers, order_);
}

}  // namespace mbgate::sim
