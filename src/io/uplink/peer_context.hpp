// SPDX-License-Identifier: Apache-2.0
// The TLS settings with which a line connects to a server: our certificate, whose key the signer
// holds, and the authorities that we trust. The files are read for each connection, so that a
// renewed one is used without a reload. Reading files and asking the signer may block.
#pragma once

#include <optional>
#include <string>

#include "bus/settings.hpp"
#include "modbus/result.hpp"
#include "sys/openssl.hpp"

namespace mbgate::io {

/// TLS 1.2 or 1.3 with the server's certificate checked by authority, dates, revocations and name.
/// The error is one line of text that names the file.
Result<sys::SslHandle, std::string> make_peer(const bus::TlsPeer& peer);

/// The server's certificate must be for this name, or this address. Why that cannot be checked;
/// nothing: it will be.
std::optional<std::string> expect_name(SSL& ssl, const std::string& name);

/// Why the server's certificate is not accepted; empty: it is, or there was none to look at.
std::string objection_to_peer(const SSL& ssl, const std::string& server_name);

}  // namespace mbgate::io
