// SPDX-License-Identifier: Apache-2.0
#include "io/clients/client_connections.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace mbgate::io {

using gateway::ClientId;

ClientConnections::ClientConnections(boost::asio::io_context& context, ConnectionEvents& events)
    : hangups_(context,
               [this](std::uint64_t key, Hangup hangup) {
                 if (auto* const client = find(ClientId{key})) {
                   client->handle_hangup(hangup);
                 }
               }),
      context_{context, hangups_, events, {}} {}

ClientId ClientConnections::add(ClientSocket socket) {
  const auto id = static_cast<ClientId>(next_client_++);
  connections_.emplace(id, std::make_shared<TcpConnection>(context_, id, std::move(socket)));
  return id;
}

TcpConnection* ClientConnections::find(ClientId client) const {
  const auto entry = connections_.find(client);
  return entry == connections_.end() ? nullptr : entry->second.get();
}

std::optional<modbus::Bytes> ClientConnections::abort(ClientId client) {
  const auto entry = connections_.extract(client);
  return entry ? std::optional(entry.mapped()->abort()) : std::nullopt;
}

void ClientConnections::close(ClientId client, bus::Duration limit) {
  if (const auto entry = connections_.extract(client)) {
    ++closing_;
    entry.mapped()->close(limit);
  }
}

void ClientConnections::close_all(bus::Duration limit) {
  for (const ClientId client : all()) {
    close(client, limit);
  }
}

void ClientConnections::read_all() {
  for (const ClientId client : all()) {
    if (auto* const connection = find(client)) {
      connection->read_waiting();
    }
  }
}

// Whatever is done with one may end others.
std::vector<ClientId> ClientConnections::all() const {
  std::vector<ClientId> clients;
  std::ranges::transform(connections_, std::back_inserter(clients),
                         [](const auto& entry) { return entry.first; });
  return clients;
}

}  // namespace mbgate::io
