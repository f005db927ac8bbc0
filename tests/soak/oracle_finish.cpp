// SPDX-License-Identifier: Apache-2.0
// What has waited too long, and what is left when everything must be over.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

constexpr Duration kOverdue = std::chrono::seconds(30);

}  // namespace

void Oracle::check_overdue() {
  const Instant now = schedule_.now();
  forget_gone_stops();
  std::vector<Asked*> late;
  for (const auto& [id, asked] : open_) {
    const Instant since =
        std::max(asked->deadline == Instant::max() ? asked->accepted : asked->deadline,
                 client_rates_.waits_since(*asked));
    if (asked->is_accepted && !asked->client_gone && !asked->overdue_reported &&
        now > since + (asked->is_stop() || asked->ordered ? kStopLife : kOverdue)) {
      late.push_back(asked.get());
    }
  }
  std::ranges::sort(late, {}, &Asked::id);
  for (Asked* asked : late) {
    asked->overdue_reported = true;
    violation("stuck", name(*asked) + " has no answer 30 s after its deadline");
  }
}

bool Oracle::has_stops() const {
  return std::ranges::any_of(books_, [](const Book& book) { return !book.open_stops.empty(); });
}

void Oracle::check_finished() {
  check_failsafes();
  for (const auto& [client, session] : sessions_) {
    for (const auto& [transaction, id] : session.by_transaction) {
      violation("unanswered", name(*open_.at(id)));
      break;
    }
  }
  for (std::size_t bus = 0; bus < books_.size(); ++bus) {
    check_told(books_[bus], bus);
    if (books_[bus].waiting > 0) {
      violation("queue_not_empty", bus_settings(bus).name + ": " +
                                       std::to_string(books_[bus].waiting) + " requests wait");
    }
  }
}

}  // namespace mbgate::soak
