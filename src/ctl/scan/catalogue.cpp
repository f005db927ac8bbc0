// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/catalogue.hpp"

#include <algorithm>

namespace mbgate::ctl {

using modbus::Table;

Catalogue::Catalogue(const std::vector<const config::ProfileFile*>& files) {
  for (const auto* file : files) {
    if (const Candidate candidate(*file); candidate.says_anything()) {
      candidates_.push_back(candidate);
    }
  }
  for (const auto& candidate : candidates_) {
    auto& confirming = confirming_.emplace_back();
    for (const auto& read : candidate.confirming_reads()) {
      confirming.push_back(add(read));
    }
    for (const auto& read : candidate.telling_reads()) {
      add(read);
    }
  }
  // 03 first: there is no drive without it in most plants, so it is the one that finds them.
  for (const auto table :
       {Table::holding_registers, Table::input_registers, Table::coils, Table::discrete_inputs}) {
    functions_.push_back(add_function_question(table));
  }
}

std::size_t Catalogue::add(const modbus::TableRange& read) {
  const auto known = std::ranges::find(questions_, read, &Question::read);
  if (known != questions_.end()) {
    return static_cast<std::size_t>(known - questions_.begin());
  }
  Question question{read, {}};
  for (const auto& candidate : candidates_) {
    question.foreseen.push_back(candidate.foresees(read));
  }
  questions_.push_back(std::move(question));
  return questions_.size() - 1;
}

std::size_t Catalogue::add_function_question(Table table) {
  std::size_t best = add({table, 0, 1});
  const auto count = [](const Question& question) {
    return std::ranges::count(question.foreseen, Foreseen::data);
  };
  for (std::size_t i = 0; i < questions_.size(); ++i) {
    const auto& read = questions_[i].read;
    if (read.table == table && read.count == 1 && count(questions_[i]) > count(questions_[best])) {
      best = i;
    }
  }
  return best;
}

}  // namespace mbgate::ctl
