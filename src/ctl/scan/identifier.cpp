// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/identifier.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::ctl {
namespace {

using modbus::TableRange;

/// So many reads must be enough; a device that fits nothing would be asked everything.
constexpr std::size_t kMostQuestions = 40;
/// A profile is likely while no more than one answer in so many contradicts it: firmware differs.
constexpr unsigned kOneIn = 4;

std::size_t pairs_told_apart(const Question& question, const std::vector<std::size_t>& suspects) {
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    for (std::size_t j = i + 1; j < suspects.size(); ++j) {
      pairs += tells_apart(question.foreseen[suspects[i]], question.foreseen[suspects[j]]) ? 1 : 0;
    }
  }
  return pairs;
}

}  // namespace

Identifier::Identifier(const Catalogue& catalogue)
    : catalogue_(&catalogue), scores_(catalogue.candidates().size()) {}

bool Identifier::was_asked(const TableRange& read) const {
  return std::ranges::find(asked_, read, &Asked::read) != asked_.end();
}

const Answer* Identifier::data_of(const TableRange& read) const {
  const auto asked = std::ranges::find(asked_, read, &Asked::read);
  return asked != asked_.end() && asked->answer.kind == AnswerKind::data ? &asked->answer : nullptr;
}

std::vector<std::size_t> Identifier::least_contradicted() const {
  std::vector<std::size_t> suspects;
  const auto least = std::ranges::min_element(scores_, {}, &Score::contradicts);
  for (std::size_t i = 0; i < scores_.size(); ++i) {
    if (scores_[i].contradicts == least->contradicts) {
      suspects.push_back(i);
    }
  }
  return suspects;
}

std::optional<std::size_t> Identifier::leader() const {
  const auto suspects = least_contradicted();
  const auto best =
      std::ranges::max_element(suspects, {}, [this](std::size_t i) { return scores_[i].fits; });
  return best == suspects.end() ? std::nullopt : std::optional(*best);
}

std::optional<TableRange> Identifier::next_telling() const {
  const auto suspects = least_contradicted();
  const Question* best = nullptr;
  std::size_t most = 0;
  for (const auto& question : catalogue_->questions()) {
    const auto pairs = pairs_told_apart(question, suspects);
    if (pairs > most && !was_asked(question.read)) {
      best = &question;
      most = pairs;
    }
  }
  return best == nullptr ? std::nullopt : std::optional(best->read);
}

std::optional<TableRange> Identifier::next() const {
  const auto& questions = catalogue_->questions();
  const auto first_of = [&](const std::vector<std::size_t>& places) {
    const auto place = std::ranges::find_if(
        places, [&](std::size_t it) { return !was_asked(questions[it].read); });
    return place == places.end() ? std::nullopt : std::optional(questions[*place].read);
  };
  if (asked_.size() >= kMostQuestions) {
    return std::nullopt;
  }
  if (const auto read = first_of(catalogue_->function_questions())) {
    return read;
  }
  if (const auto read = next_telling()) {
    return read;
  }
  const auto best = leader();
  return best ? first_of(catalogue_->confirming(*best)) : std::nullopt;
}

void Identifier::take(const TableRange& read, Answer answer) {
  for (std::size_t i = 0; i < scores_.size(); ++i) {
    const auto verdict = catalogue_->candidates()[i].judge(read, answer);
    scores_[i].fits += verdict == Verdict::fits ? 1 : 0;
    scores_[i].contradicts += verdict == Verdict::contradicts ? 1 : 0;
  }
  asked_.push_back({read, std::move(answer)});
}

Identification Identifier::result() const {
  Identification result;
  for (const auto& asked : asked_) {
    if (asked.answer.kind == AnswerKind::data) {
      result.functions.set(read_function(asked.read.table));
    }
  }
  const auto best = leader();
  if (!best) {
    return result;
  }
  const Score score = scores_[*best];
  result.nearest = &catalogue_->candidates()[*best].file();
  result.fitting = score.fits;
  result.judged = score.fits + score.contradicts;
  if (score.fits == 0 || score.contradicts * kOneIn > result.judged) {
    return result;
  }
  for (std::size_t i = 0; i < scores_.size(); ++i) {
    if (scores_[i] == score) {
      result.likely.push_back(&catalogue_->candidates()[i].file());
    }
  }
  read_contents(result);
  return result;
}

/// What the best of the profiles says about registers that were read.
void Identifier::read_contents(Identification& result) const {
  const auto& file = *result.likely.front();
  const auto& profile = file.profile;
  for (const auto& string : file.strings) {
    if (const auto* answer = data_of(string.fact)) {
      const auto order = profile.word_order.value_or(drive::WordOrder::big);
      if (auto text = register_text(answer->registers, order); !text.empty()) {
        result.texts.push_back({string.source.name, std::move(text)});
      }
    }
  }
  result.word_order = profile.word_order;
  if (const auto& codes = profile.word_order_register) {
    const auto* answer = data_of({modbus::Table::holding_registers, codes->address, 1});
    if (answer != nullptr) {
      result.word_order = order_of(*codes, answer->registers.front());
    }
  }
}

}  // namespace mbgate::ctl
