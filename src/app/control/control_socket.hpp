// SPDX-License-Identifier: Apache-2.0
// The socket that mbgatectl talks to: a Unix socket in the file system, which its owner and group
// may use.
#pragma once

#include <boost/asio/local/stream_protocol.hpp>
#include <string>

#include "modbus/result.hpp"

namespace mbgate::app {

/// Listens at `path`. What an ended process has left there is replaced. The error says why not, in
/// a sentence that names the path.
Result<boost::asio::local::stream_protocol::acceptor, std::string> open_control_socket(
    boost::asio::io_context& context, const std::string& path);

}  // namespace mbgate::app
