// SPDX-License-Identifier: Apache-2.0
// TLS over a socket that does not block: one step of OpenSSL at a time, and the event that the next
// step waits for. The caller waits in its own way: with poll(2), or as a coroutine.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "sys/openssl.hpp"

namespace mbgate::sys {

/// Lets OpenSSL have one record of the other end at a time. Of its own it reads on until there is
/// data: as long as the other end sends records without any (new keys, renegotiations, pieces of a
/// handshake), which may be for ever.
class RecordGate {
 public:
  using Instant = std::chrono::steady_clock::time_point;
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
  Turn turn(Instant at);

 private:
  static long on_read(BIO* bio, int what, const char* bytes, std::size_t size, int argument,
                      long number, int result, std::size_t* processed);
  void note(std::span<const char> bytes);
  [[nodiscard]] std::size_t size_left() const;

  std::array<std::uint8_t, 5> head_{};
  std::size_t head_size_ = 0;
  std::size_t left_ = 0;  ///< of the record, once all of its head has come
  bool has_passed_ = false;
  Instant rested_at_ = Instant::min();  ///< a second after the last of a hundred in a row
};

class TlsStream {
 public:
  enum class Step : std::uint8_t {
    done,
    read_more,   ///< the next one, once the socket can be read
    write_more,  ///< the next one, once it can be written
    again,       ///< the next one, after others had their turn
    closed,      ///< the other end has said goodbye
    broken,      ///< system_error(), or if that is 0 take_openssl_error(), says why
    flooded,     ///< kFlood
  };
  static constexpr const char* kFlood =
      "more than 100 records without data within a second (new keys, renegotiations, pieces of a "
      "handshake, empty ones)";

  /// The socket stays its owner's.
  TlsStream(SslHandle ssl, int socket);
  TlsStream(const TlsStream&) = delete;
  TlsStream& operator=(const TlsStream&) = delete;
  ~TlsStream() = default;

  Step shake_hands();
  /// How many bytes were carried if it is done.
  Step read(std::span<std::uint8_t> room, std::size_t& count);
  Step write(std::span<const std::uint8_t> bytes, std::size_t& count);
  /// Done: our goodbye was sent.
  Step say_goodbye();

  [[nodiscard]] SSL& ssl() const { return *ssl_; }
  /// An errno if the connection broke; 0: OpenSSL objected, or the end came without a goodbye.
  [[nodiscard]] int system_error() const { return system_error_; }
  /// Did it break because the other end was suddenly gone?
  [[nodiscard]] bool is_cut() const { return is_cut_; }

 private:
  void prepare();
  Step step_after(int result);
  Step step_to_wait(Step wish);

  SslHandle ssl_;
  RecordGate records_;
  int system_error_ = 0;
  bool is_cut_ = false;
};

/// Of a client: TLS 1.2 or 1.3, where the server must have a certificate that is trusted. Nothing:
/// OpenSSL says why.
ContextHandle client_context();
/// The server's certificate must be for this name, or this address. False: none can be.
bool expect_name(SSL& ssl, const std::string& name);

/// Does nothing follow it?
inline bool is_over(TlsStream::Step step) { return step >= TlsStream::Step::closed; }

}  // namespace mbgate::sys
