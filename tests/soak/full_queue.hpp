// SPDX-License-Identifier: Apache-2.0
// Who has to make room in a full queue: the client address with the most waiting.
#pragma once

#include "soak/oracle_books.hpp"

namespace mbgate::soak {

/// Surely another client address than the request's own had more waiting than that.
/// `taken`: so many requests may have their turn, and wait no more. `lateness`: so long before it
/// is told who has made room.
bool had_another_more(const Book& book, std::size_t bus, const Asked& evicted, std::size_t taken,
                      Duration lateness, Instant now);
}  // namespace mbgate::soak
