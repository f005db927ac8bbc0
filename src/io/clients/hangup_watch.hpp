// SPDX-License-Identifier: Apache-2.0
// Notices that a peer has closed its connection while nothing is read from the socket. Asio's
// wait_error does not fire for a FIN or a reset behind unread data. An epoll instance of our own
// does, and is itself watched through Asio.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <cstdint>
#include <functional>

namespace mbgate::io {

enum class Hangup : std::uint8_t {
  fin,   ///< the peer will send nothing more
  reset  ///< the connection is gone
};

class HangupWatch {
 public:
  /// `key` is what was given to watch().
  using Callback = std::function<void(std::uint64_t key, Hangup hangup)>;

  HangupWatch(boost::asio::io_context& context, Callback callback);
  HangupWatch(const HangupWatch&) = delete;
  HangupWatch& operator=(const HangupWatch&) = delete;
  ~HangupWatch() = default;

  /// Reports the first hang-up of the socket, once; call again for the next. Without `fin` only a
  /// reset is reported. A second call for a watched socket replaces the first. False if the kernel
  /// refuses.
  [[nodiscard]] bool watch(int socket, std::uint64_t key, bool fin);
  /// To be called before the socket is closed or read again.
  void forget(int socket);

 private:
  boost::asio::awaitable<void> run();
  void report_all();

  boost::asio::posix::stream_descriptor epoll_;
  Callback callback_;
};

}  // namespace mbgate::io
