// SPDX-License-Identifier: Apache-2.0
// The thread of TLS: handshakes and records, so that no bus waits for them. It meets the machine
// only through posted events and pairs of sockets.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "io/clients/hangup_watch.hpp"
#include "io/heartbeat.hpp"
#include "io/tls/tls_client.hpp"
#include "io/tls/tls_context.hpp"

namespace mbgate::io {

class TlsFront {
 public:
  /// `home`: of the thread of the machine, where `events` are told.
  TlsFront(boost::asio::io_context& home, TlsEvents& events);
  TlsFront(const TlsFront&) = delete;
  TlsFront& operator=(const TlsFront&) = delete;
  /// Lets clients that the machine has closed have their last bytes, for a moment.
  ~TlsFront();

  /// The thread of the machine calls these. Shakes hands; tls_arrived() or tls_refused() follows.
  void take(TlsCandidate candidate);
  /// Ends the handshake of this number, unless its ClientHello has come meanwhile.
  void let_go(std::uint64_t handshake, std::string why);
  /// From now on these decide: ends clients whose certificates they do not accept, or whose
  /// listener has none any more. Handshakes under way are judged at their end.
  void judge_again(ListenerContexts contexts);

 private:
  struct Entry {
    std::shared_ptr<TlsClient> client;
    TlsPlace place;
    bool is_old = false;  ///< the thread was stopped during the handshake
  };

  void run();
  boost::asio::awaitable<void> serve(std::uint64_t key, gateway::HandshakeSettings limits);
  /// Hands a client that has shaken hands to the machine. False: it cannot be.
  bool hand_over(Entry& entry);
  /// Do the settings in force accept it? Else it is ended, and the machine hears why.
  bool judge(const Entry& entry);
  void refuse(const TlsPlace& place, const std::string& why);
  /// nullptr: it has gone.
  [[nodiscard]] std::shared_ptr<TlsClient> client_of(std::uint64_t key) const;
  void look_for_stall();
  void forget(std::uint64_t key);
  void finish();
  template <typename Told>
  void tell(Told told);

  boost::asio::io_context& home_;
  TlsEvents& events_;
  boost::asio::io_context io_{1};
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  HangupWatch hangups_;
  HangupWatch closings_;
  Heartbeat heartbeat_;
  TlsClientContext shared_;
  ListenerContexts contexts_;
  std::map<std::uint64_t, Entry> clients_;  ///< by the numbers of their handshakes
  bool is_ending_ = false;
  std::thread thread_;
};

}  // namespace mbgate::io
