// SPDX-License-Identifier: Apache-2.0
#include "integration/far_server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace mbgate::test {
namespace {

unsigned word(const std::uint8_t* bytes) { return (unsigned{bytes[0]} << 8U) + bytes[1]; }

bool is_write(unsigned function) { return function != 0x03 && function != 0x04; }

}  // namespace

FarServer::FarServer(std::uint16_t port)
    : listening_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)),
      context_(modbus_new_tcp("127.0.0.1", port)),
      mapping_(modbus_mapping_new(kRegisters, kRegisters, kRegisters, kRegisters)) {
  const int on = 1;
  setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const name = reinterpret_cast<sockaddr*>(&address);
  if (bind(listening_, name, size) != 0 || listen(listening_, 8) != 0 ||
      getsockname(listening_, name, &size) != 0 || pipe2(stop_, O_CLOEXEC) != 0) {
    throw std::runtime_error("no far server on port " + std::to_string(port));
  }
  port_ = ntohs(address.sin_port);
  std::iota(mapping_->tab_registers, mapping_->tab_registers + kRegisters, 1000);
  std::iota(mapping_->tab_input_registers, mapping_->tab_input_registers + kRegisters, 2000);
  thread_ = std::thread([this] { serve(); });
}

FarServer::~FarServer() {
  close(stop_[1]);
  thread_.join();
  std::ranges::for_each(connections_, close);
  close(stop_[0]);
  close(listening_);
}

std::vector<Arrival> FarServer::arrivals() {
  const std::lock_guard lock(mutex_);
  return arrivals_;
}

void FarServer::serve() {
  while (serve_once()) {
  }
}

bool FarServer::serve_once() {
  std::vector<pollfd> watched{{stop_[0], POLLIN, 0}, {listening_, POLLIN, 0}};
  for (const int connection : connections_) {
    watched.push_back({connection, POLLIN, 0});
  }
  if (poll(watched.data(), watched.size(), waiting_.empty() ? -1 : gather_limit_ms_.load()) == 0) {
    answer_all();
    return true;
  }
  if (watched[0].revents != 0) {
    return false;
  }
  if (watched[1].revents != 0) {
    accept_one();
  }
  for (std::size_t i = 2; i < watched.size(); ++i) {
    if (watched[i].revents != 0 && std::ranges::count(connections_, watched[i].fd) > 0) {
      take_query(watched[i].fd);
    }
  }
  if (waiting_.size() >= gather_) {
    answer_all();
  }
  return true;
}

void FarServer::accept_one() {
  const int connection = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
  ++accepted_;
  if (closes_at_once_) {
    close(connection);
  } else {
    connections_.push_back(connection);
  }
}

void FarServer::hang_up(int socket) {
  close(socket);
  std::erase(connections_, socket);
  const auto from_there = [socket](const Query& other) { return other.socket == socket; };
  std::erase_if(waiting_, from_there);
  if (late_ && from_there(*late_)) {
    late_.reset();
  }
}

void FarServer::take_query(int socket) {
  Query query{socket, {}, 0};
  modbus_set_socket(context_.get(), socket);
  query.size = modbus_receive(context_.get(), query.bytes.data());
  if (query.size <= 0) {
    hang_up(socket);
    return;
  }
  const std::uint8_t* const bytes = query.bytes.data();
  {
    const std::lock_guard lock(mutex_);
    arrivals_.push_back({word(bytes), bytes[6], bytes[7], word(bytes + 8)});
  }
  waiting_.push_back(query);
}

void FarServer::answer_all() {
  most_waiting_ = std::max(most_waiting_.load(), waiting_.size());
  const bool writes =
      std::ranges::any_of(waiting_, [](const Query& query) { return is_write(query.bytes[7]); });
  had_company_ = had_company_ || (writes && waiting_.size() > 1);
  while (!waiting_.empty()) {
    const Query query = waiting_.back();
    waiting_.pop_back();
    answer(query);
  }
}

void FarServer::answer(const Query& query) {
  const unsigned address = word(query.bytes.data() + 8);
  if (address == kSilentRegister) {
    return;
  }
  if (address == kLateRegister) {
    late_ = query;
    return;
  }
  if (address == kVendorRegister) {
    send_exception(query, 0x11);
    return;
  }
  if (address == kPathRegister) {
    send_exception(query, 0x0A);
    return;
  }
  if (late_) {
    modbus_set_socket(context_.get(), late_->socket);
    modbus_reply(context_.get(), late_->bytes.data(), late_->size, mapping_.get());
    late_.reset();
  }
  if (address == kCuttingRegister) {
    cuts_ = !cuts_;
    if (cuts_) {
      hang_up(query.socket);
      return;
    }
  }
  auto answered = query.bytes;
  answered[6] = unit_ < 0 ? answered[6] : static_cast<std::uint8_t>(unit_);
  modbus_set_socket(context_.get(), query.socket);
  modbus_reply(context_.get(), answered.data(), query.size, mapping_.get());
  if (closes_after_answers_ || address == kClosingRegister) {
    hang_up(query.socket);
  }
}

// libmodbus sends only the exceptions that the specification knows.
void FarServer::send_exception(const Query& query, std::uint8_t code) const {
  const auto& request = query.bytes;
  const std::array<std::uint8_t, 9> adu{
      request[0], request[1], 0, 0, 0, 3, request[6], static_cast<std::uint8_t>(request[7] | 0x80U),
      code};
  send(query.socket, adu.data(), adu.size(), MSG_NOSIGNAL);
}

}  // namespace mbgate::test
