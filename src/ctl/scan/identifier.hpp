// SPDX-License-Identifier: Apache-2.0
// Finds out what a unit is, by reading: says what to read next, takes what came, and in the end
// names the profiles that fit. Knows no connection, so that it can be tried on anything.
#pragma once

#include <bitset>
#include <optional>
#include <string>
#include <vector>

#include "ctl/scan/catalogue.hpp"

namespace mbgate::ctl {

/// A text of the device and what its profile calls it: model name, software version.
struct NamedText {
  std::string name;
  std::string text;
};

struct Identification {
  /// The profiles that fit best; several cannot be told apart by reading, none means that no
  /// profile fits.
  std::vector<const config::ProfileFile*> likely;
  /// The profile that came nearest; nullptr if there is no candidate at all.
  const config::ProfileFile* nearest = nullptr;
  unsigned fitting = 0;      ///< answers that fit it
  unsigned judged = 0;       ///< of so many that could
  std::bitset<5> functions;  ///< 1 to 4: those that gave data
  std::vector<NamedText> texts;
  std::optional<drive::WordOrder> word_order;  ///< as the maker fixed it, or as it was read
};

class Identifier {
 public:
  /// `catalogue` must live as long.
  explicit Identifier(const Catalogue& catalogue);

  /// What to read next; nothing if no further read would help. The first one is answered by about
  /// every device, if only with an exception.
  [[nodiscard]] std::optional<modbus::TableRange> next() const;
  /// What came of the read that next() named.
  void take(const modbus::TableRange& read, Answer answer);
  [[nodiscard]] Identification result() const;

 private:
  struct Score {
    unsigned fits = 0;
    unsigned contradicts = 0;
    friend bool operator==(const Score&, const Score&) = default;
  };
  struct Asked {
    modbus::TableRange read;
    Answer answer;
  };
  [[nodiscard]] bool was_asked(const modbus::TableRange& read) const;
  [[nodiscard]] const Answer* data_of(const modbus::TableRange& read) const;
  [[nodiscard]] std::vector<std::size_t> least_contradicted() const;
  [[nodiscard]] std::optional<std::size_t> leader() const;
  [[nodiscard]] std::optional<modbus::TableRange> next_telling() const;
  void read_contents(Identification& result) const;

  const Catalogue* catalogue_;
  std::vector<Score> scores_;  ///< by candidate
  std::vector<Asked> asked_;
};

}  // namespace mbgate::ctl
