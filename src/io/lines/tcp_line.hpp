// SPDX-License-Identifier: Apache-2.0
// A TCP connection in place of a serial line: to a Modbus TCP server, or to a serial device server.
// No request is delivered late: if the far end does not take or acknowledge what was sent, the
// connection is closed, and what the kernel still holds is discarded with it.
#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/settings.hpp"
#include "io/lines/line.hpp"
#include "io/uplink/tls_uplink.hpp"
#include "modbus/result.hpp"

namespace mbgate::io {

// The parts of its opening.

/// The most addresses of a host that are tried: further ones would only delay the report that it
/// cannot be reached.
inline constexpr std::size_t kMaxHostAddresses = 4;

using HostAddresses = std::vector<boost::asio::ip::tcp::endpoint>;

/// The name of the server in messages: "tcp://drive.plant:502", "tcp://[::1]:502".
std::string to_text(const bus::Endpoint& remote);

/// The address of the server; nothing if the host is a name and not an IPv4 or IPv6 address.
std::optional<boost::asio::ip::tcp::endpoint> numeric_endpoint(const bus::Endpoint& remote);

/// Asks the system's resolver, which may block while the name servers do not answer. The addresses
/// are in the resolver's order of preference, kMaxHostAddresses at most. The error says why there
/// is none.
Result<HostAddresses, std::string> resolve(const bus::Endpoint& remote);

/// Sets how soon the kernel gives a connection up. Returns a line of text for each that could not
/// be set; it begins with `name`, the name of the server.
std::vector<std::string> set_options(int socket, const bus::ConnectionTimes& times,
                                     const std::string& name);

class TcpLine final : public Line {
 public:
  /// `line` has a remote end.
  TcpLine(LineContext context, drive::BusId bus, const bus::LineSettings& line);
  ~TcpLine() override;

  void open() override;
  std::optional<std::string> transmit(modbus::Bytes frame) override;
  void read_now() override;
  [[nodiscard]] bool has_bytes() override;
  void close() override;
  /// False while a name is being looked up: it is that of the previous server.
  [[nodiscard]] bool adopt(const bus::LineSettings& settings) override {
    if (!settings.remote || resolving_ || state_ != State::closed) {
      return false;
    }
    remote_ = *settings.remote;
    times_ = settings.connection;
    tls_ = settings.tls;
    name_ = to_text(remote_);
    late_.reset();
    return true;
  }

 private:
  enum class State : std::uint8_t { closed, opening, open };

  void resolve_name();
  void limit_resolving();
  void finish_resolving(Result<HostAddresses, std::string> result);
  void start_connecting(HostAddresses addresses);
  boost::asio::awaitable<void> connect(HostAddresses addresses, unsigned generation);
  boost::asio::awaitable<void> read_loop(unsigned generation);
  boost::asio::awaitable<void> write_rest(unsigned generation);
  boost::asio::awaitable<std::optional<std::string>> secure(unsigned generation);
  void finish_open();
  void fail_to_open(const std::string& why);
  void lose(const std::string& why);
  void note_end(const boost::system::error_code& error);
  void close_socket();

  LineContext context_;
  drive::BusId bus_;
  bus::Endpoint remote_;
  bus::ConnectionTimes times_;
  std::optional<bus::TlsPeer> tls_;
  std::string name_;                     ///< of the server, in messages
  std::optional<TlsUplink> uplink_;      ///< with TLS, which has the TCP connection then
  std::vector<std::string> warnings_;    ///< of its options
  boost::asio::ip::tcp::socket socket_;  ///< with TLS, one end of the uplink's pair
  boost::asio::steady_timer timer_;      ///< limits looking the name up, connecting, writing
  State state_ = State::closed;
  bool resolving_ = false;  ///< a thread waits for the name servers
  bool given_up_ = false;   ///< the attempt to open it: they have not answered in time
  /// They have then, for the next attempt.
  std::optional<HostAddresses> late_;
  /// Counts openings and closings, so that a coroutine of an earlier connection notices that its
  /// connection is closed.
  unsigned generation_ = 0;
  std::vector<std::uint8_t> rest_;  ///< not taken by the kernel yet
  std::array<std::uint8_t, kLineReadSize> buffer_{};
};

}  // namespace mbgate::io
