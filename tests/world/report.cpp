// SPDX-License-Identifier: Apache-2.0
#include "world/report.hpp"

namespace mbgate::world {
namespace {

void add_to(Report::Counts& sum, const Report::Counts& more) {
  for (const auto& [kind, count] : more) {
    sum[kind] += count;
  }
}

std::string line(const char* title, const Report::Counts& counts) {
  std::string text = std::string("  ") + title + ":";
  for (const auto& [kind, count] : counts) {
    text += ' ' + kind + ' ' + std::to_string(count);
  }
  return counts.empty() ? "" : text + '\n';
}

}  // namespace

void Report::add(const Report& other) {
  transactions += other.transactions;
  requests += other.requests;
  answers += other.answers;
  virtual_time += other.virtual_time;
  add_to(exceptions, other.exceptions);
  add_to(faults, other.faults);
  add_to(apart, other.apart);
  add_to(violations, other.violations);
  texts.insert(texts.end(), other.texts.begin(), other.texts.end());
}

std::string Report::summary() const {
  const auto seconds = virtual_time / std::chrono::seconds(1);
  return std::to_string(transactions) + " transactions, " + std::to_string(requests) +
         " requests, " + std::to_string(answers) + " good answers, " + std::to_string(seconds) +
         " s of virtual time\n" + line("exceptions", exceptions) + line("faults", faults) +
         line("counted apart", apart) + line("violations", violations);
}

}  // namespace mbgate::world
