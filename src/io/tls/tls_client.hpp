// SPDX-License-Identifier: Apache-2.0
// One client that speaks TLS, on the thread of TLS: its handshake, and then what it says and hears,
// carried between its socket and one end of a pair of sockets. The machine has the other end, which
// is to it as any client's socket: bytes, FIN, back-pressure. Nothing is kept here but what fits
// into two small buffers.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bus/instant.hpp"
#include "io/clients/hangup_watch.hpp"
#include "io/tls/tls_context.hpp"
#include "sys/tls_stream.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

/// What clients of the thread of TLS share.
struct TlsClientContext {
  boost::asio::io_context& io;
  HangupWatch& hangups;   ///< of their sockets
  HangupWatch& closings;  ///< of their ends of the pairs: the machine has closed its own
  /// To be called before anything of a client is handed on.
  std::function<void()> look_for_stall;
};

/// Whoever awaits one of its coroutines holds it meanwhile.
class TlsClient : public std::enable_shared_from_this<TlsClient> {
 public:
  TlsClient(TlsClientContext& shared, std::uint64_t key, std::shared_ptr<TlsContext> context,
            boost::asio::ip::tcp::socket socket);

  /// Nothing: it is done; else why not. `greeted` is called when the ClientHello has come.
  boost::asio::awaitable<std::optional<std::string>> shake_hands(gateway::HandshakeSettings limits,
                                                                 std::function<void()> greeted);
  /// After a handshake that failed: lets the client have the alert, and ends.
  boost::asio::awaitable<void> drain_and_end();
  /// After the handshake: the end of the pair that is for the machine; closed if there is none.
  sys::UniqueFd make_pair();
  /// Carries on until both have ended.
  boost::asio::awaitable<void> carry();
  /// Carries to the machine what can be carried without waiting. How many bytes that were.
  std::size_t drain();
  /// Both ends of the pair have said all: ends after a moment, also if the client reads nothing.
  void linger();
  /// Ends at once. `why`: if that has to be told.
  void end(const std::string& why = {});

  [[nodiscard]] routing::ClientRole role() const;
  /// Why the certificate would not be accepted now; nothing: it would.
  [[nodiscard]] std::optional<std::string> objection(const TlsContext& context) const;
  [[nodiscard]] bool has_greeted() const { return has_greeted_; }
  [[nodiscard]] bool has_pair() const { return pair_.is_open(); }
  /// What the client did that ended it; empty: nothing that has to be told.
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  using Step = sys::TlsStream::Step;

  boost::asio::awaitable<void> carry_up();
  boost::asio::awaitable<void> carry_down();
  boost::asio::awaitable<bool> write_down(std::span<const std::uint8_t> bytes);
  boost::asio::awaitable<void> say_goodbye();
  boost::asio::awaitable<bool> wait_for(Step step);
  boost::asio::awaitable<bool> wait_for_room();
  /// Ends then, unless the timer is set again. `why`: as of end().
  void end_at(boost::asio::steady_timer::time_point when, const char* why = "");
  /// All of its ClientHello, of which pieces do not count.
  [[nodiscard]] bool has_hello() const;
  /// Remembers what there is to complain of.
  Step note(Step step);
  Step read_up();
  bool hand_up();

  TlsClientContext& shared_;
  std::uint64_t key_;
  std::shared_ptr<TlsContext> context_;
  boost::asio::ip::tcp::socket socket_;
  sys::TlsStream stream_;
  boost::asio::local::stream_protocol::socket pair_;
  boost::asio::steady_timer timer_;
  std::vector<std::uint8_t> up_;  ///< read from the client, not yet with the machine
  std::string complaint_;
  bool has_greeted_ = false;
  bool is_down_ended_ = false;  ///< the machine has said all
};

}  // namespace mbgate::io
