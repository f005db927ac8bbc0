// SPDX-License-Identifier: Apache-2.0
#include "io/clients/server_set.hpp"

#include <boost/asio/post.hpp>
#include <utility>

namespace mbgate::io {

void ServerSet::add(gateway::ListenerId listener, boost::asio::ip::tcp::acceptor acceptor,
                    int end) {
  servers_.push_back(
      std::make_unique<TcpServer>(context_, listener, std::move(acceptor), events_, end));
  if (started_) {
    servers_.back()->start();
  }
}

void ServerSet::remove(gateway::ListenerId listener) {
  for (auto& server : servers_) {
    if (server->listener() == listener) {
      server->stop();
      // What waits for a client ends before this does.
      boost::asio::post(context_, [stopped = std::move(server)] {});
    }
  }
  std::erase(servers_, nullptr);
}

void ServerSet::set_end(int end) {
  for (const auto& server : servers_) {
    server->set_end(end);
  }
}

void ServerSet::start() {
  for (const auto& server : servers_) {
    server->accept_waiting();
  }
  for (const auto& server : servers_) {
    server->start();
  }
  started_ = true;
}

void ServerSet::stop() {
  for (const auto& server : servers_) {
    server->stop();
  }
}

}  // namespace mbgate::io
