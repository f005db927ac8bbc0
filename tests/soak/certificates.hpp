// SPDX-License-Identifier: Apache-2.0
// What clients' certificates say of their roles.
#pragma once

#include "routing/client_role.hpp"

namespace mbgate::soak {

/// The role as the product reads it from a certificate that says so.
routing::ClientRole read_in_certificate(const routing::ClientRole& role, unsigned host);

}  // namespace mbgate::soak
