// SPDX-License-Identifier: Apache-2.0
// Identifies a unit by reading: says what to read next, takes the answer, and in the end names the
// profiles that fit. It has no connection of its own, so that it can be tested on anything.
#pragma once

#include <bitset>
#include <optional>
#include <string>
#include <vector>

#include "ctl/scan/candidate.hpp"

namespace mbgate::ctl {

/// A text of the device and its name in the profile: model name, software version.
struct NamedText {
  std::string name;
  std::string text;
};

struct Identification {
  /// The profiles that fit best. Several: they cannot be told apart by reading. None: no profile
  /// fits.
  std::vector<const config::ProfileFile*> likely;
  /// The profile that fits most nearly; nullptr if there is no candidate at all.
  const config::ProfileFile* nearest = nullptr;
  unsigned fitting = 0;      ///< answers that fit it
  unsigned judged = 0;       ///< answers that could fit or contradict it
  std::bitset<5> functions;  ///< 1 to 4: those that gave data
  std::vector<NamedText> texts;
  std::optional<drive::WordOrder> word_order;  ///< as the maker fixed it, or as it was read
};

class Identifier {
 public:
  /// `catalogue` must outlive this object.
  explicit Identifier(const Catalogue& catalogue);

  /// What to read next; nothing if no further read would help. Nearly every device answers the
  /// first read, if only with an exception.
  [[nodiscard]] std::optional<modbus::TableRange> next() const;
  /// Takes the answer to the read that next() returned.
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
