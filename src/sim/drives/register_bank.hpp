// SPDX-License-Identifier: Apache-2.0
// The registers of a simulated drive, as its manual lists them. A table of runs says which
// registers there are, how wide they are, who may do what, and within which limits. The bank holds
// the values. A 32-bit value is held as one value and only presented in the drive's word order, so
// a wrong word order elsewhere shows at once. Coils and discrete inputs are registers that hold 0
// or 1.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drive/values.hpp"
#include "modbus/result.hpp"

namespace mbgate::sim {

enum class Access : std::uint8_t { read_only, write_only, read_write };
enum class Width : std::uint8_t { word = 1, value = 2 };  ///< registers of an entry

/// Both ends belong to the range. A negative `lowest` makes the entry signed.
struct Limits {
  std::int64_t lowest;
  std::int64_t highest;
};
/// Off or on.
inline constexpr Limits kSwitch{0, 1};

/// `entries` equal entries, one after the other, from protocol address `first` on.
struct RegisterRun {
  std::uint16_t first;
  std::uint16_t entries;
  Width width = Width::word;
  Access access = Access::read_write;
  std::uint32_t initial = 0;
  std::optional<Limits> limits = std::nullopt;
  std::uint32_t step = 0;  ///< by which each entry is higher than the one before it, at first
};

/// Runs in ascending order, without overlaps.
using RegisterMap = std::span<const RegisterRun>;

/// The registers of one request: no more than any function carries, coils included.
using Registers = boost::container::static_vector<std::uint16_t, 2000>;

enum class Refusal : std::uint8_t { no_such_register, not_readable, not_writable, out_of_range };

class RegisterBank {
 public:
  RegisterBank(RegisterMap map, drive::WordOrder order);

  /// What a client reads. Half a value is returned as such.
  [[nodiscard]] Result<Registers, Refusal> read(std::uint16_t first, std::uint16_t count) const;
  /// What a client writes: all of it or nothing. Half a value replaces that half.
  std::optional<Refusal> write(std::uint16_t first, std::span<const std::uint16_t> words);

  /// The drive's own access, without rights and limits: the whole entry that `address` belongs to.
  /// The address must be in the map.
  [[nodiscard]] std::uint32_t get(std::uint16_t address) const;
  void set(std::uint16_t address, std::uint32_t value);

  /// Presents the values in another order from now on.
  void set_word_order(drive::WordOrder order) { order_ = order; }
  /// Every entry gets its initial value again.
  void restore_initial();

 private:
  /// One register of an entry.
  struct Place {
    const RegisterRun* run;
    std::size_t entry;  ///< its place in values_
    std::size_t half;   ///< which of its registers, in address order
  };
  struct Change {
    Place place;
    std::uint32_t value;
  };
  using Changes = boost::container::static_vector<Change, 128>;

  [[nodiscard]] std::optional<Place> find(std::uint32_t address) const;
  [[nodiscard]] std::uint16_t word_of(const Place& place) const;
  [[nodiscard]] std::uint32_t with_word(const Place& place, std::uint32_t value,
                                        std::uint16_t word) const;
  [[nodiscard]] std::optional<Refusal> collect(std::uint16_t first,
                                               std::span<const std::uint16_t> words,
                                               Changes& changes) const;

  std::vector<RegisterRun> runs_;
  std::vector<std::size_t> offsets_;  ///< of each run's first entry in values_
  std::vector<std::uint32_t> values_;
  drive::WordOrder order_;
};

}  // namespace mbgate::sim
