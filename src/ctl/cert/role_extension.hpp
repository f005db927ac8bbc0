// SPDX-License-Identifier: Apache-2.0
// The role in a client's certificate: the X.509v3 extension 1.3.6.1.4.1.50316.802.1 of the
// Modbus/TCP Security protocol, whose value is one UTF8String, the whole role.
#pragma once

#include <string>

#include "ctl/tls/openssl.hpp"
#include "routing/client_role.hpp"

namespace mbgate::ctl {

/// Why a certificate should not have this role, a sentence, or nothing.
std::string wrong_role(const std::string& role);

/// `role` must not be wrong.
void add_role(X509& certificate, const std::string& role);

/// What a gateway reads in a certificate: its own function says what it is.
routing::ClientRole read_role(const X509& certificate);

}  // namespace mbgate::ctl
