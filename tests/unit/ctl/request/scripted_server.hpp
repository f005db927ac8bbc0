// SPDX-License-Identifier: Apache-2.0
// A Modbus TCP server that answers as it is told, whatever the requests are.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

namespace mbgate::ctl {

/// Listens on a free port and serves one connection after the other: each gets its answers in
/// order, and is closed after the last one. An answer is what follows the MBAP header's length: the
/// unit and the PDU. An empty one: the connection is closed instead.
class ScriptedServer {
 public:
  using Bytes = std::vector<std::uint8_t>;
  using Answers = std::vector<Bytes>;

  /// `spoil` changes each answer, with its header, before it is sent.
  explicit ScriptedServer(
      std::vector<Answers> connections, std::function<void(Bytes&)> spoil = [](Bytes&) {})
      : listener_(socket(AF_INET, SOCK_STREAM, 0)), spoil_(std::move(spoil)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(bind(listener_, generic, size), 0);
    EXPECT_EQ(getsockname(listener_, generic, &size), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this, connections = std::move(connections)] {
      for (const auto& answers : connections) {
        serve(answers);
        ++closed_;
        closed_.notify_all();
      }
    });
  }
  ~ScriptedServer() {
    thread_.join();
    close(listener_);
  }
  ScriptedServer(const ScriptedServer&) = delete;
  ScriptedServer& operator=(const ScriptedServer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Returns when the first connection has been closed.
  void wait_until_one_is_closed() const { closed_.wait(0); }

 private:
  void serve(const Answers& answers) const {
    pollfd ready{.fd = listener_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, 10'000) != 1) {
      return;
    }
    const int client = accept(listener_, nullptr, nullptr);
    for (const auto& answer : answers) {
      std::array<std::uint8_t, 260> request{};
      if (recv(client, request.data(), request.size(), 0) <= 0 || answer.empty()) {
        break;
      }
      Bytes response(request.begin(), request.begin() + 4);
      response.push_back(0);
      response.push_back(static_cast<std::uint8_t>(answer.size()));
      response.insert(response.end(), answer.begin(), answer.end());
      spoil_(response);
      send(client, response.data(), response.size(), MSG_NOSIGNAL);
    }
    close(client);
  }

  int listener_;
  std::function<void(Bytes&)> spoil_;
  std::uint16_t port_ = 0;
  std::atomic<int> closed_ = 0;
  std::thread thread_;
};

}  // namespace mbgate::ctl
