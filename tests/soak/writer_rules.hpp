// SPDX-License-Identifier: Apache-2.0
// Who may write to a device by its `writer`, as far as it can be told from outside: what was on the
// wire was accepted, at the latest then and not before it could be read.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "soak/asked.hpp"

namespace mbgate::soak {

class WriterRules {
 public:
  explicit WriterRules(const SoakPlan& plan) : plan_(plan), books_(plan.settings.devices.size()) {}

  /// Marks a write that its client may never do: 01, or 06 because of a stop.
  void refuse_unlisted(Asked& asked) const;
  /// The gateway may have accepted it by now.
  void attempted(const Asked& asked, Instant now);
  /// It was answered, or its client has gone; `now` and some lateness later it is not accepted.
  void closed(const Asked& asked, Instant now, Duration lateness);
  /// It was transmitted for the first time. Who owns writing instead of its client; nothing if it
  /// may be its client.
  std::string sent(const Asked& asked, Instant now);
  /// It is not there: nobody owns it.
  void gone(std::size_t device) { books_[device] = {}; }
  /// May another one own writing to one of the devices?
  [[nodiscard]] bool may_be_held(const Asked& asked, Instant now) const;

 private:
  struct Written {
    Instant accepted;  ///< not before
    Instant sent;
  };
  struct Book {
    std::map<unsigned, Written> written;              ///< by host, what it wrote last
    std::map<unsigned, Instant> attempted;            ///< by host
    std::map<std::uint64_t, unsigned> perhaps_later;  ///< host, by what is accepted later perhaps
  };
  [[nodiscard]] std::vector<std::size_t> devices_of(const Asked& asked) const;
  [[nodiscard]] const gateway::DeviceGuard& guard(std::size_t device) const {
    return plan_.settings.guards[device];
  }

  const SoakPlan& plan_;
  std::vector<Book> books_;
};

}  // namespace mbgate::soak
