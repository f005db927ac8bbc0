// SPDX-License-Identifier: Apache-2.0
// Lets OpenSSL have one record of the other end at a time. Of its own it reads on until there is
// data: as long as the other end sends records without any (new keys, renegotiations, pieces of a
// handshake), which may be for ever.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "bus/instant.hpp"
#include "gateway/second_rate.hpp"
#include "io/tls/openssl_handles.hpp"

namespace mbgate::io {

class RecordGate {
 public:
  static constexpr const char* kTooMany =
      "more than 100 records without data within a second (new keys, renegotiations, pieces of a "
      "handshake, empty ones)";
  /// What follows a call of OpenSSL that would have to wait.
  enum class Turn : std::uint8_t {
    wait,     ///< for the socket
    again,    ///< there may be more records; others first
    too_many  ///< records without data
  };

  /// Watches what is read from the socket that `ssl` was given, for as long as that is used.
  void watch(SSL& ssl);
  /// To be called before each call of OpenSSL that may read.
  void open() { has_passed_ = false; }
  /// To be asked, once, after a call that has brought no data.
  Turn turn(bus::Instant at);

 private:
  static long on_read(BIO* bio, int what, const char* bytes, std::size_t size, int argument,
                      long number, int result, std::size_t* processed);
  void note(std::span<const char> bytes);
  [[nodiscard]] std::size_t size_left() const;

  std::array<std::uint8_t, 5> head_{};
  std::size_t head_size_ = 0;
  std::size_t left_ = 0;  ///< of the record, once all of its head has come
  bool has_passed_ = false;
  gateway::SecondRate without_data_;
};

}  // namespace mbgate::io
