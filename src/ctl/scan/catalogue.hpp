// SPDX-License-Identifier: Apache-2.0
// The candidates of a scan and the reads that tell them apart, computed once.
#pragma once

#include <cstddef>
#include <vector>

#include "ctl/scan/candidate.hpp"

namespace mbgate::ctl {

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
