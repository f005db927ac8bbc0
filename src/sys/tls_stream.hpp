// SPDX-License-Identifier: Apache-2.0
// TLS over a socket that does not block: one step of OpenSSL at a time, and the event that the next
// step waits for. The caller waits in its own way: with poll(2), or as a coroutine.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
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

/// Carries bytes between a TLS stream and a plain socket, which is one end of a pair: the code at
/// the other end needs no TLS. It blocks, on a thread of its own, and holds a few kilobytes.
class TlsPump {
 public:
  enum class End : std::uint8_t {
    none,    ///< the handshake is done
    plain,   ///< the other end of the pair was closed
    late,    ///< the time is over
    stream,  ///< that of the stream, as last_step() and the stream say
  };

  /// `socket`: that of the stream. Neither it nor `plain` (-1: none yet) blocks.
  TlsPump(TlsStream& stream, int socket, int plain)
      : stream_(stream), socket_(socket), plain_(plain) {}

  /// Nothing as the limit: for ever.
  End shake_hands(std::optional<std::chrono::steady_clock::time_point> limit);
  /// Until there is an end. `stall_limit`: how long the other end of the stream may take nothing of
  /// what it is sent.
  End carry(std::optional<std::chrono::milliseconds> stall_limit);

  [[nodiscard]] TlsStream::Step last_step() const { return last_step_; }
  /// Do we, or does the kernel, hold what the other end of the stream has not taken?
  [[nodiscard]] bool has_unsent() const;

 private:
  enum class Move : std::uint8_t { done, must_wait, ended };
  /// Bytes on their way in one direction.
  struct Portion {
    std::array<std::uint8_t, 2048> bytes{};
    std::size_t begin = 0;
    std::size_t end = 0;

    [[nodiscard]] bool is_empty() const { return begin == end; }
    [[nodiscard]] std::span<const std::uint8_t> left() const {
      return std::span(bytes).subspan(begin, end - begin);
    }
    void fill(std::size_t count) {
      begin = 0;
      end = count;
    }
  };

  Move carry_up();
  Move carry_down();
  Move move_after(TlsStream::Step step);
  Move end_with(End end);
  void wait(short plain_events, std::chrono::milliseconds time);
  [[nodiscard]] bool is_plain_closed() const;

  TlsStream& stream_;
  int socket_;
  int plain_;
  short events_ = 0;  ///< that the socket is waited for
  Portion up_;
  Portion down_;
  End end_ = End::none;
  TlsStream::Step last_step_ = TlsStream::Step::done;
};

}  // namespace mbgate::sys
