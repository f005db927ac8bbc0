// SPDX-License-Identifier: Apache-2.0
// A profile as a suspect: what a drive of that kind must answer to a read, and whether an answer
// fits. Everything comes out of the profile; no drive is known by name here.
#pragma once

#include <string>
#include <vector>

#include "config/profiles/profile_file.hpp"
#include "ctl/scan/scan_answer.hpp"

namespace mbgate::ctl {

/// What a profile says will come of a read.
enum class Foreseen : std::uint8_t {
  anything,     ///< the profile does not say
  data,         ///< every register is there and may be read
  text,         ///< the same, and it is a text
  word_order,   ///< the same, and it is one of the codes of a word order
  no_function,  ///< the drive does not have the function
  refusal       ///< it has the function, but not this place, or not so many at once
};

enum class Verdict : std::uint8_t { fits, contradicts, open };

class Candidate {
 public:
  /// `file` must live as long.
  explicit Candidate(const config::ProfileFile& file);

  [[nodiscard]] const config::ProfileFile& file() const { return *file_; }
  /// Does the profile say which registers there are? One that does not fits everything.
  [[nodiscard]] bool says_anything() const { return !map_.empty(); }
  [[nodiscard]] Foreseen foresees(const modbus::TableRange& read) const;
  [[nodiscard]] Verdict judge(const modbus::TableRange& read, const Answer& answer) const;

  /// Reads at the borders of what the drive has: what tells it from others.
  [[nodiscard]] std::vector<modbus::TableRange> telling_reads() const;
  /// A few reads that every drive of this kind must answer as foreseen: its texts, its word order,
  /// the end of its longest run of registers in each table, one more than its limit.
  [[nodiscard]] std::vector<modbus::TableRange> confirming_reads() const;

 private:
  [[nodiscard]] modbus::Table held_in(modbus::Table table) const;
  [[nodiscard]] Foreseen content(const modbus::TableRange& read) const;
  [[nodiscard]] std::vector<modbus::TableRange> content_reads() const;
  void add_limit_read(modbus::Table table, std::vector<modbus::TableRange>& reads) const;

  const config::ProfileFile* file_;
  drive::RangeList map_;  ///< by table and address; neighbours are one
};

/// A text out of registers: where a drive has the low word first, it has the low byte first too.
/// Blanks and zeros around it are left out; empty if it is none.
std::string register_text(const std::vector<std::uint16_t>& registers, drive::WordOrder order);

}  // namespace mbgate::ctl
