// SPDX-License-Identifier: Apache-2.0
#include "soak/writer_rules.hpp"

#include <algorithm>

namespace mbgate::soak {

using gateway::WriterRule;

std::vector<std::size_t> WriterRules::devices_of(const Asked& asked) const {
  std::vector<std::size_t> devices;
  if (asked.door == nullptr || !asked.changes() || asked.is_stop()) {
    return devices;
  }
  if (asked.door->device) {
    return {*asked.door->device};
  }
  for (std::size_t device = 0; device < books_.size(); ++device) {
    const auto bus = static_cast<std::size_t>(plan_.settings.devices[device].bus);
    // It counts as a write to every device of each bus that it goes out on.
    const bool hears =
        !plan_.absent.devices[device] &&
        std::ranges::any_of(asked.pieces, [&](const Piece& piece) { return piece.bus == bus; });
    if (hears) {
      devices.push_back(device);
    }
  }
  return devices;
}

void WriterRules::refuse_unlisted(Asked& asked) const {
  for (const std::size_t device : devices_of(asked)) {
    const auto& listed = plan_.writers[device];
    if (!asked.refused && guard(device).writer == WriterRule::listed &&
        std::ranges::find(listed, asked.host) == listed.end()) {
      asked.refused = 1;
      asked.unlisted = true;
    }
  }
}

void WriterRules::attempted(const Asked& asked, Instant now) {
  for (const std::size_t device : devices_of(asked)) {
    books_[device].attempted[asked.host] = now;
    if (asked.ahead) {
      books_[device].perhaps_later.emplace(asked.id, asked.host);
    }
  }
}

void WriterRules::closed(const Asked& asked, Instant now, Duration lateness) {
  for (Book& book : books_) {
    if (book.perhaps_later.erase(asked.id) > 0) {
      book.attempted[asked.host] = now + lateness;
    }
  }
}

std::string WriterRules::sent(const Asked& asked, Instant now) {
  std::string owner;
  for (const std::size_t device : devices_of(asked)) {
    auto& written = books_[device].written;
    for (const auto& [host, last] : written) {
      if (host != asked.host && guard(device).writer == WriterRule::first &&
          last.sent < asked.accepted && now < last.accepted + guard(device).writer_hold) {
        owner = "host " + std::to_string(host) + " owns " + plan_.settings.devices[device].name;
      }
    }
    written[asked.host] = {asked.accepted, now};
  }
  return owner;
}

// Not while its own client surely owns writing, and nobody else has it.
bool WriterRules::may_be_held(const Asked& asked, Instant now) const {
  return std::ranges::any_of(devices_of(asked), [&](std::size_t device) {
    const Book& book = books_[device];
    const Duration hold = guard(device).writer_hold;
    const auto own = book.written.find(asked.host);
    const bool is_owner = own != book.written.end() && own->second.sent < asked.accepted &&
                          now < own->second.accepted + hold;
    const auto may_hold = [&](const auto& other) {
      return other.first != asked.host && other.second + hold > asked.accepted;
    };
    const auto is_others = [&](const auto& later) { return later.second != asked.host; };
    const bool has_attempted = std::ranges::any_of(book.attempted, may_hold) ||
                               std::ranges::any_of(book.perhaps_later, is_others);
    return guard(device).writer == WriterRule::first && !is_owner && has_attempted;
  });
}

}  // namespace mbgate::soak
