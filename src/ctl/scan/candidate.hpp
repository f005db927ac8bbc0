// SPDX-License-Identifier: Apache-2.0
// A profile as a candidate for an unknown drive: what a drive of that kind must answer to a read,
// and whether an answer fits. All of it comes from the profile; no drive is known by name here.
#pragma once

#include <string>
#include <vector>

#include "config/profiles/profile_file.hpp"
#include "ctl/scan/scan_answer.hpp"

namespace mbgate::ctl {

/// What a profile predicts for a read.
enum class Foreseen : std::uint8_t {
  anything,     ///< the profile does not say
  data,         ///< every register exists and may be read
  text,         ///< the same, and the data are a text
  word_order,   ///< the same, and the value is one of the codes for a word order
  no_function,  ///< the drive does not have the function
  refusal       ///< it has the function, but not these addresses, or not so many at once
};

enum class Verdict : std::uint8_t { fits, contradicts, open };

class Candidate {
 public:
  /// `file` must outlive this object.
  explicit Candidate(const config::ProfileFile& file);

  [[nodiscard]] const config::ProfileFile& file() const { return *file_; }
  /// Does the profile say which registers there are? If not, it fits every drive.
  [[nodiscard]] bool says_anything() const { return !map_.empty(); }
  [[nodiscard]] Foreseen foresees(const modbus::TableRange& read) const;
  [[nodiscard]] Verdict judge(const modbus::TableRange& read, const Answer& answer) const;

  /// Reads at the borders of the drive's registers, which tell it from other drives.
  [[nodiscard]] std::vector<modbus::TableRange> telling_reads() const;
  /// A few reads that every drive of this kind must answer as predicted: its texts, its word order,
  /// the end of its longest run of registers in each table, one register more than its limit.
  [[nodiscard]] std::vector<modbus::TableRange> confirming_reads() const;

 private:
  [[nodiscard]] modbus::Table held_in(modbus::Table table) const;
  [[nodiscard]] Foreseen content(const modbus::TableRange& read) const;
  [[nodiscard]] std::vector<modbus::TableRange> content_reads() const;
  void add_limit_read(modbus::Table table, std::vector<modbus::TableRange>& reads) const;

  const config::ProfileFile* file_;
  drive::RangeList map_;  ///< by table and address; adjacent ranges are joined
};

/// A text from registers. A drive with the low word first also has the low byte first. Blanks and
/// zeros around the text are removed. Empty if it is not a text.
std::string register_text(const std::vector<std::uint16_t>& registers, drive::WordOrder order);

}  // namespace mbgate::ctl
