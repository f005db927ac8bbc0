// SPDX-License-Identifier: Apache-2.0
// From a host and a port to a connection over TLS 1.2 or 1.3 with a server that is known: mutual
// authentication, as Modbus/TCP Security has it.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "ctl/request/command.hpp"
#include "ctl/tls/descriptor.hpp"
#include "ctl/tls/openssl.hpp"
#include "modbus/result.hpp"

namespace mbgate::ctl {

/// A connection whose handshake is done. The socket does not block.
struct TlsConnection {
  Descriptor socket;
  openssl::Context context;
  openssl::Session session;
};

/// Within `timeout`, the TCP connection and the handshake together. The error says why, in words
/// that follow "cannot connect to HOST:PORT: ".
Result<TlsConnection, std::string> connect_tls(const std::string& host, std::uint16_t port,
                                               std::chrono::nanoseconds timeout,
                                               const TlsIdentity& identity);

/// What SSL_read, SSL_write or SSL_connect failed of, for `result` that they gave: "the server
/// refused our certificate: certificate expired".
std::string failure_text(const SSL& session, int result);

}  // namespace mbgate::ctl
