// SPDX-License-Identifier: Apache-2.0
// From a host and a port to a connection over TLS 1.2 or 1.3 with a server that is known: mutual
// authentication, as Modbus/TCP Security has it.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "ctl/request/command.hpp"
#include "modbus/result.hpp"
#include "sys/tls_stream.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::ctl {

/// A connection whose handshake is done. The socket does not block.
struct TlsConnection {
  sys::UniqueFd socket;
  std::unique_ptr<sys::TlsStream> stream;
};

/// Within `timeout`, the TCP connection and the handshake together. The error says why, in words
/// that follow "cannot connect to HOST:PORT: ".
Result<TlsConnection, std::string> connect_tls(const std::string& host, std::uint16_t port,
                                               std::chrono::nanoseconds timeout,
                                               const TlsIdentity& identity);

/// Why the stream is over after this step: "the server refused our certificate: certificate
/// expired".
std::string failure_text(const sys::TlsStream& stream, sys::TlsStream::Step step);

}  // namespace mbgate::ctl
