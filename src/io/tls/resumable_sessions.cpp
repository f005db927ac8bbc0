// SPDX-License-Identifier: Apache-2.0
#include "io/tls/resumable_sessions.hpp"

#include <iterator>
#include <utility>

namespace mbgate::io {

std::string id_of(const SSL_SESSION* session) {
  unsigned int size = 0;
  const unsigned char* const id = SSL_SESSION_get_id(session, &size);
  return {id, id + size};
}

void ResumableSessions::keep(sys::SessionHandle session, sys::ChainHandle chain) {
  std::string id = id_of(session.get());
  if (id.empty()) {
    return;
  }
  forget(id);
  if (kept_.size() >= most_) {
    forget(std::string(kept_.front().id));
  }
  kept_.push_back({id, std::move(session), std::move(chain)});
  by_id_[std::move(id)] = std::prev(kept_.end());
}

ResumableSessions::Kept* ResumableSessions::find(std::string_view id) {
  const auto entry = by_id_.find(std::string(id));
  return entry == by_id_.end() ? nullptr : &*entry->second;
}

void ResumableSessions::forget(std::string_view id) {
  if (const auto entry = by_id_.extract(std::string(id))) {
    kept_.erase(entry.mapped());
  }
}

}  // namespace mbgate::io
