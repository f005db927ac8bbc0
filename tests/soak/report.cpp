// SPDX-License-Identifier: Apache-2.0
#include "soak/report.hpp"

#include <numeric>

namespace mbgate::soak {
namespace {

using Counts = std::map<std::string, std::uint64_t>;

std::string list(const char* title, const Counts& counts) {
  std::string text = std::string("  ") + title + ":";
  for (const auto& [kind, count] : counts) {
    text += " " + kind + " " + std::to_string(count);
  }
  return text + (counts.empty() ? " none\n" : "\n");
}

void add_counts(Counts& to, const Counts& from) {
  for (const auto& [kind, count] : from) {
    to[kind] += count;
  }
}

}  // namespace

std::uint64_t Report::violation_count() const {
  return std::accumulate(violations.begin(), violations.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& entry) { return sum + entry.second; });
}

void Report::add(const Report& other) {
  transmissions += other.transmissions;
  requests += other.requests;
  answers += other.answers;
  exceptions += other.exceptions;
  virtual_time += other.virtual_time;
  add_counts(faults, other.faults);
  add_counts(violations, other.violations);
  add_counts(apart, other.apart);
  add_counts(reasons, other.reasons);
  add_counts(starts, other.starts);
  for (const auto& [code, count] : other.codes) {
    codes[code] += count;
  }
}

std::string Report::summary() const {
  std::string text = std::to_string(transmissions) + " transactions, " + std::to_string(requests) +
                     " requests, " + std::to_string(answers) + " answers, " +
                     std::to_string(exceptions) + " exceptions, virtual time " +
                     std::to_string(virtual_time.count() / 1'000'000'000) + " s\n";
  Counts named;
  for (const auto& [code, count] : codes) {
    constexpr char kDigits[] = "0123456789ABCDEF";
    named[std::string{kDigits[code >> 4U & 15U], kDigits[code & 15U]}] = count;
  }
  return text + list("exception codes", named) + list("reasons", reasons) + list("faults", faults) +
         list("counted apart", apart) + list("of these at starts", starts) +
         list("violations", violations);
}

}  // namespace mbgate::soak
