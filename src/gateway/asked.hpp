// SPDX-License-Identifier: Apache-2.0
// The client and the contents of a request, with all that the journal needs so that somebody can be
// found afterwards.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gateway/client.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::gateway {

/// A client, and what its certificate says of it.
struct Asker {
  ListenerId listener{};
  routing::ClientAddress address;
  routing::ClientRole role{};
};

/// A request of a client, as it was sent.
struct Asked : Asker {
  std::uint8_t unit = 0;
  std::vector<std::uint8_t> pdu{};
};

Asker asker_of(const ClientInfo& client);
Asked asked_of(const ClientInfo& client, const modbus::MbapAdu& adu);

/// ` (role "operator", certificate "panel 3")`; of a client without a certificate nothing.
std::string identity_text(const Asker& asker);

/// "function 16 at unit 1, holding registers 100..103 = 5 0 0 7": the addresses are those of the
/// client, the values decimal, and not more of them than an operator can make use of.
std::string request_text(const Asked& asked);

}  // namespace mbgate::gateway
