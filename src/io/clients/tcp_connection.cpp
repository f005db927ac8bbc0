// SPDX-License-Identifier: Apache-2.0
#include "io/clients/tcp_connection.hpp"

#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <utility>

#include "io/supervise.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

using boost::system::error_code;

namespace {

/// The client has reset it, for one; what it had sent before can be read nevertheless.
bool is_gone(int socket) {
  pollfd asked{socket, 0, 0};
  return ::poll(&asked, 1, 0) > 0;
}

}  // namespace

std::size_t unread_bytes(int socket) {
  int bytes = 0;
  return ::ioctl(socket, FIONREAD, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

TcpConnection::TcpConnection(ConnectionContext& context, gateway::ClientId client,
                             ClientSocket socket)
    : context_(context), client_(client), socket_(std::move(socket)) {}

void TcpConnection::start() {
  if (!reading_ && !fin_seen_) {
    reading_ = true;
    supervise(context_.io, read_loop(shared_from_this()), "client read");
  }
}

bool TcpConnection::pause() {
  paused_ = true;
  if (fin_seen_) {
    return true;  // watched since the FIN
  }
  watched_ = context_.hangups.watch(socket_.native_handle(), static_cast<std::uint64_t>(client_),
                                    !fin_reported_);
  return watched_;
}

void TcpConnection::resume() {
  paused_ = false;
  if (!fin_seen_) {
    stop_watching();
    start();
    boost::asio::post(context_.io, [self = shared_from_this()] { self->read_waiting(); });
  }
}

TcpConnection::SendOutcome TcpConnection::send(const modbus::MbapBytes& adu) {
  answered_ = true;
  if (outbox_.empty()) {
    const auto count = sys::send_now(socket_.native_handle(), adu);
    if (!count) {
      return SendOutcome::failed;
    }
    if (*count == adu.size()) {
      return SendOutcome::sent;
    }
    written_ = *count;
  }
  outbox_.push_back(adu);
  start_writing();
  return SendOutcome::queued;
}

void TcpConnection::close(bus::Duration limit) {
  stop_watching();
  closing_.emplace(context_.io, limit);
  const bool nothing_can_be_lost = outbox_.empty() && (fin_seen_ || !answered_);
  if (nothing_can_be_lost) {
    finish();
    return;
  }
  closing_->async_wait([weak = weak_from_this()](const error_code& error) {
    if (const auto self = weak.lock(); self && !error) {
      self->finish();
    }
  });
  start_writing();
}

modbus::Bytes TcpConnection::abort() {
  const modbus::Bytes unread = read_rest(0);
  close_socket();
  return unread;
}

// What can still be read, behind so many bytes that have been read.
modbus::Bytes TcpConnection::read_rest(std::size_t have) {
  ReadBuffer& buffer = context_.buffer;
  for (ssize_t count = 1; count > 0;
       have += static_cast<std::size_t>(std::max<ssize_t>(count, 0))) {
    count =
        ::recv(socket_.native_handle(), buffer.data() + have, buffer.size() - have, MSG_DONTWAIT);
  }
  return modbus::Bytes(buffer).first(have);
}

void TcpConnection::close_socket() {
  stop_watching();
  error_code ignored;
  socket_.close(ignored);
}

void TcpConnection::handle_hangup(Hangup hangup) {
  switch (hangup) {
    case Hangup::reset: disconnect(); return;
    case Hangup::fin:
      // One shot: a reset is still to be noticed.
      if (context_.hangups.watch(socket_.native_handle(), static_cast<std::uint64_t>(client_),
                                 false)) {
        fin_reported_ = true;
        context_.events.client_half_closed(client_);
      } else {
        disconnect();
      }
      return;
  }
}

boost::asio::awaitable<void> TcpConnection::read_loop(std::shared_ptr<TcpConnection> self) {
  while (!self->paused_ && !self->fin_seen_ && !self->closing_ && self->socket_.is_open()) {
    const auto [error] = co_await self->socket_.async_wait(ClientSocket::wait_read, kAsTuple);
    if (error) {
      break;
    }
    if (!self->paused_ && !self->closing_) {
      self->read_once();
    }
  }
  self->reading_ = false;
}

void TcpConnection::read_once() {
  ReadBuffer& buffer = context_.buffer;
  const ssize_t count =
      ::recv(socket_.native_handle(), buffer.data(), gateway::kClientReadSize, MSG_DONTWAIT);
  if (count > 0) {
    const auto size = static_cast<std::size_t>(count);
    if (is_gone(socket_.native_handle())) {
      const modbus::Bytes unread = read_rest(size);
      close_socket();
      context_.events.client_disconnected(client_, unread);
      return;
    }
    const std::size_t unread =
        size < gateway::kClientReadSize ? 0 : unread_bytes(socket_.native_handle());
    context_.events.client_bytes(client_, modbus::Bytes(buffer).first(size), unread);
  } else if (count == 0) {
    handle_fin();
  } else if (!sys::would_block(errno)) {
    disconnect();
  }
}

// Bytes that come later must not be taken for ones that came during the pause, so an empty socket
// is reported.
void TcpConnection::read_waiting() {
  if (paused_ || fin_seen_ || closing_ || !socket_.is_open()) {
    return;
  }
  if (unread_bytes(socket_.native_handle()) == 0) {
    context_.events.client_bytes(client_, {}, 0);
  } else {
    read_once();
  }
}

void TcpConnection::handle_fin() {
  fin_seen_ = true;
  watched_ =
      context_.hangups.watch(socket_.native_handle(), static_cast<std::uint64_t>(client_), false);
  if (watched_) {
    context_.events.client_half_closed(client_);
  } else {
    disconnect();
  }
}

void TcpConnection::start_writing() {
  if (!writing_) {
    writing_ = true;
    supervise(context_.io, write_loop(shared_from_this()), "client write");
  }
}

boost::asio::awaitable<void> TcpConnection::write_loop(std::shared_ptr<TcpConnection> self) {
  while (self->socket_.is_open() && !self->outbox_.empty()) {
    const auto [error] = co_await self->socket_.async_wait(ClientSocket::wait_write, kAsTuple);
    if (error || !self->write_queued()) {
      break;
    }
  }
  self->writing_ = false;
  if (self->closing_ && self->socket_.is_open()) {
    co_await discard_until_fin(self);
    self->finish();
  }
}

bool TcpConnection::write_queued() {
  while (socket_.is_open() && !outbox_.empty()) {
    const modbus::Bytes rest = modbus::Bytes(outbox_.front()).subspan(written_);
    const auto count = sys::send_now(socket_.native_handle(), rest);
    if (!count) {
      closing_ ? finish() : disconnect();
      return false;
    }
    if (*count < rest.size()) {
      written_ += *count;
      return true;
    }
    outbox_.pop_front();
    written_ = 0;
    if (!closing_) {
      context_.events.client_sent(client_);  // may send, or close this connection
    }
  }
  return socket_.is_open();
}

boost::asio::awaitable<void> TcpConnection::discard_until_fin(std::shared_ptr<TcpConnection> self) {
  error_code ignored;
  self->socket_.shutdown(ClientSocket::shutdown_send, ignored);
  while (!self->fin_seen_ && self->socket_.is_open()) {
    const auto [error] = co_await self->socket_.async_wait(ClientSocket::wait_read, kAsTuple);
    if (error) {
      co_return;
    }
    ReadBuffer& buffer = self->context_.buffer;
    const ssize_t count =
        ::recv(self->socket_.native_handle(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (count == 0 || (count < 0 && !sys::would_block(errno))) {
      co_return;
    }
  }
}

void TcpConnection::disconnect() {
  const modbus::Bytes unread = abort();
  context_.events.client_disconnected(client_, unread);
}

void TcpConnection::finish() {
  if (socket_.is_open()) {
    close_socket();
    closing_->cancel();
    context_.events.client_closed(client_);
  }
}

void TcpConnection::stop_watching() {
  if (std::exchange(watched_, false)) {
    context_.hangups.forget(socket_.native_handle());
  }
}

}  // namespace mbgate::io
