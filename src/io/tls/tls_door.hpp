// SPDX-License-Identifier: Apache-2.0
// Clients of listeners with TLS, on the thread of the machine: how many shake hands at a time, and
// what has become of them. The handshakes themselves are another thread's (TlsFront).
//
// To change
// - the clients that may begin a handshake: tls_door, on the machine's thread; the handshake:
//   tls_client, on the thread of tls_front.
// - records, and the number of records without data: sys/tls_stream. The machine has one end of a
//   pair of sockets, which GatewayDriver treats as any client's.
// - versions, suites, checks of certificates, resumption of sessions: tls_context.
// - private keys: remote_key asks signer_client, which asks signer/door; their protocol:
//   base/signing; which files are keys, and which of these belong to an authority: signer/key_file;
//   what may be signed: signer/padding.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "gateway/second_rate.hpp"
#include "io/clients/tcp_server.hpp"
#include "io/tls/tls_context.hpp"
#include "io/tls/tls_front.hpp"

namespace mbgate::io {

class TlsDoor final : public TlsEvents {
 public:
  TlsDoor(boost::asio::io_context& context, TlsEvents& events)
      : context_(context), events_(events) {}
  TlsDoor(const TlsDoor&) = delete;
  TlsDoor& operator=(const TlsDoor&) = delete;
  ~TlsDoor() override = default;

  /// For handshakes from now on. Clients whose certificates these do not accept are ended.
  void use(ListenerContexts contexts);
  /// A client that has connected to a listener with TLS, and may connect.
  void take(gateway::ListenerId number, const gateway::Settings& settings, AcceptedClient client);
  /// Handshakes under way.
  [[nodiscard]] std::size_t under_way() const;

 private:
  struct Handshake {
    routing::ClientAddress client;  ///< as it is counted
    bool has_greeted = false;       ///< its ClientHello has come
  };
  struct OfClient {
    std::size_t under_way = 0;
    gateway::SecondRate begun;
  };
  struct OfListener {
    std::map<std::uint64_t, Handshake> under_way;  ///< by their numbers: the oldest first
    std::map<routing::ClientAddress, OfClient> clients;
    gateway::SecondRate begun;
  };

  void tls_greeted(const TlsPlace& place) override;
  void tls_arrived(TlsArrival arrival) override;
  void tls_refused(const TlsPlace& place, const std::string& why) override;
  void tls_behind(std::chrono::milliseconds missed) override { events_.tls_behind(missed); }
  void tls_drained() override { events_.tls_drained(); }

  /// Why no other handshake may begin there now; empty: it may, and counts from now on.
  std::string begin(const TlsPlace& place, const gateway::HandshakeSettings& limits);
  /// Lets the oldest go that has not brought its ClientHello; of this client only, if there is one.
  /// False: all have.
  bool make_room(OfListener& listener, const routing::ClientAddress* client, const char* limit);
  Handshake& note_begun(const TlsPlace& place);
  static void note_ended(OfListener& listener, std::uint64_t handshake);

  boost::asio::io_context& context_;
  TlsEvents& events_;
  ListenerContexts contexts_;
  std::map<gateway::ListenerId, OfListener> listeners_;
  std::uint64_t next_handshake_ = 0;
  std::unique_ptr<TlsFront> front_;  ///< none as long as nobody needs it
};

}  // namespace mbgate::io
