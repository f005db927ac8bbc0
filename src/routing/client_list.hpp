// SPDX-License-Identifier: Apache-2.0
// A list of clients in the configuration: by address, by the role in their certificate, or by its
// name.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "routing/client_address.hpp"
#include "routing/client_role.hpp"

namespace mbgate::routing {

struct ClientList {
  ClientList() = default;
  ClientList(std::initializer_list<Network> blocks) : networks(blocks) {}
  ClientList(NetworkList blocks) : networks(std::move(blocks)) {}

  [[nodiscard]] bool empty() const {
    return networks.empty() && roles.empty() && certificates.empty();
  }
  /// Can no more than one client be in it?
  [[nodiscard]] bool names_one() const {
    return roles.empty() && networks.size() + certificates.size() == 1 &&
           (networks.empty() || networks.front().is_host());
  }
  /// Is it the client's address, its role or its certificate? A role that cannot be read is none.
  [[nodiscard]] bool contains(const ClientAddress& address, const ClientRole& role) const;
  friend bool operator==(const ClientList&, const ClientList&) = default;

  NetworkList networks{};
  std::vector<std::string> roles{};         ///< "": the NULL role
  std::vector<std::string> certificates{};  ///< common names
};

}  // namespace mbgate::routing
