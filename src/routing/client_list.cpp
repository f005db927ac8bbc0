// SPDX-License-Identifier: Apache-2.0
#include "routing/client_list.hpp"

#include <algorithm>

namespace mbgate::routing {

bool ClientList::contains(const ClientAddress& address, const ClientRole& role) const {
  const bool has_role =
      role.kind == ClientRole::Kind::named && std::ranges::find(roles, role.name) != roles.end();
  const bool has_certificate =
      !role.certificate.empty() &&
      std::ranges::find(certificates, role.certificate) != certificates.end();
  return has_role || has_certificate || routing::contains(networks, address);
}

}  // namespace mbgate::routing
