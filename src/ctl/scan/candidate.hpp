// SPDX-License-Identifier: Apache-2.0
// A profile as a candidate for an unknown drive: what a drive of that kind must answer to a read,
// and whether an answer fits. All of it comes from the profile; no drive is known by name here.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config/profiles/profile_file.hpp"
#include "modbus/request.hpp"

namespace mbgate::ctl {

enum class AnswerKind : std::uint8_t {
  data,
  exception,
  busy,    ///< an exception that says nothing about the device: try again later
  no_way,  ///< the gateway did not transmit it
  silence
};

struct Answer {
  AnswerKind kind = AnswerKind::silence;
  std::uint8_t exception = 0;
  std::vector<std::uint16_t> registers{};  ///< of `data`; bits as 0 and 1
  std::chrono::nanoseconds took{0};
};

/// The function that reads the table.
inline std::uint8_t read_function(modbus::Table table) {
  return modbus::make_read({table, 0, 1}).function();
}

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
  [[nodiscard]] Foreseen content(const modbus::TableRange& read) const;
  [[nodiscard]] std::vector<modbus::TableRange> content_reads() const;
  void add_limit_read(modbus::Table table, std::vector<modbus::TableRange>& reads) const;

  const config::ProfileFile* file_;
  drive::RangeList map_;  ///< by table and address; adjacent ranges are joined
};

/// What a code in the drive's register for it means; nothing if it is neither.
std::optional<drive::WordOrder> order_of(const drive::WordOrderRegister& codes, std::uint16_t code);

/// A text from registers. A drive with the low word first also has the low byte first. Blanks and
/// zeros around the text are removed. Empty if it is not a text.
std::string register_text(const std::vector<std::uint16_t>& registers, drive::WordOrder order);

/// The candidates of a scan and the reads that tell them apart, computed once.
struct Question {
  modbus::TableRange read;
  std::vector<Foreseen> foreseen;  ///< by candidate
};

/// Can an answer fit the one and contradict the other?
constexpr bool tells_apart(Foreseen one, Foreseen other) {
  return one != other && one != Foreseen::anything && other != Foreseen::anything;
}

class Catalogue {
 public:
  /// The files must outlive this object. Profiles that name no registers are not candidates.
  explicit Catalogue(const std::vector<const config::ProfileFile*>& files);

  [[nodiscard]] const std::vector<Candidate>& candidates() const { return candidates_; }
  [[nodiscard]] const std::vector<Question>& questions() const { return questions_; }
  /// The indices in questions() of one read for each of the functions 03, 04, 01 and 02, at
  /// addresses where most of the candidates have data.
  [[nodiscard]] const std::vector<std::size_t>& function_questions() const { return functions_; }
  /// The indices in questions() of the reads that confirm a candidate.
  [[nodiscard]] const std::vector<std::size_t>& confirming(std::size_t candidate) const {
    return confirming_[candidate];
  }

 private:
  std::size_t add(const modbus::TableRange& read);
  std::size_t add_function_question(modbus::Table table);

  std::vector<Candidate> candidates_;
  std::vector<Question> questions_;
  std::vector<std::size_t> functions_;
  std::vector<std::vector<std::size_t>> confirming_;
};

}  // namespace mbgate::ctl
