// SPDX-License-Identifier: Apache-2.0
// A client's connection to the HTTP interface, over the Unix socket or over TCP.
#pragma once

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <chrono>

namespace mbgate::app {

using ControlStream = boost::beast::basic_stream<boost::asio::generic::stream_protocol>;

/// How long a client may take for its request, or for taking what is sent to it.
inline constexpr std::chrono::seconds kClientLimit{10};

}  // namespace mbgate::app
