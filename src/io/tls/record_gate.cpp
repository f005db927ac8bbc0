// SPDX-License-Identifier: Apache-2.0
#include "io/tls/record_gate.hpp"

#include <openssl/bio.h>

#include <algorithm>

namespace mbgate::io {
namespace {

/// A handshake needs some ten, and renewing keys one a day.
constexpr unsigned kMostWithoutData = 100;  // within a second

}  // namespace

void RecordGate::watch(SSL& ssl) {
  BIO* const bio = SSL_get_rbio(&ssl);
  BIO_set_callback_arg(bio, reinterpret_cast<char*>(this));
  BIO_set_callback_ex(bio, on_read);
}

RecordGate::Turn RecordGate::turn(bus::Instant at) {
  if (!has_passed_) {
    return Turn::wait;
  }
  if (!without_data_.has_room(kMostWithoutData, at)) {
    return Turn::too_many;
  }
  without_data_.take(kMostWithoutData, at);
  return Turn::again;
}

// Called before and after (BIO_CB_RETURN) each operation of the BIO.
long RecordGate::on_read(BIO* bio, int what, const char* bytes, std::size_t /*size*/,
                         int /*argument*/, long /*number*/, int result, std::size_t* processed) {
  auto* const gate = reinterpret_cast<RecordGate*>(BIO_get_callback_arg(bio));
  if (what == BIO_CB_READ && gate->has_passed_ && gate->head_size_ == 0) {
    BIO_clear_retry_flags(bio);
    BIO_set_retry_read(bio);
    return -1;
  }
  if (what == (BIO_CB_READ | BIO_CB_RETURN) && result > 0) {
    gate->note({bytes, *processed});
  }
  return (what & BIO_CB_RETURN) != 0 ? result : 1;
}

void RecordGate::note(std::span<const char> bytes) {
  while (!bytes.empty()) {
    std::size_t taken = 1;
    if (head_size_ < head_.size()) {
      head_[head_size_++] = static_cast<std::uint8_t>(bytes.front());
      left_ = size_left();
    } else {
      taken = std::min(left_, bytes.size());
      left_ -= taken;
    }
    bytes = bytes.subspan(taken);
    if (head_size_ == head_.size() && left_ == 0) {
      has_passed_ = true;
      head_size_ = 0;
    }
  }
}

/// Of the record behind its head. The first one of a connection may be of SSL 2.0, whose head has
/// two bytes (RFC 5246, E.2).
std::size_t RecordGate::size_left() const {
  if ((head_[0] & 0x80U) != 0) {
    const std::size_t size = (head_[0] & 0x7FU) << 8U | head_[1];
    return size + 2 > head_.size() ? size + 2 - head_.size() : 0;
  }
  return static_cast<std::size_t>(head_[3] << 8U | head_[4]);
}

}  // namespace mbgate::io
