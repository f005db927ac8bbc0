// SPDX-License-Identifier: Apache-2.0
// Which requests are allowed over TCP: only reads, and only those whose Host names this machine.
// Otherwise a foreign web page could point its own name here (DNS rebinding) and read the status. A
// request that a browser marks as that of a foreign page (Origin) is refused on either kind of
// socket.
#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/status.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mbgate::app {

/// The answer to a request that gets no other.
struct Refusal {
  boost::beast::http::status status;
  std::string why;
};

/// Does the Host of a request mean this machine: an address, "localhost" or one of `hosts`, which
/// are in small letters? Each may have a port.
bool is_own_host(std::string_view host, const std::vector<std::string>& hosts);

/// Is a page of this origin ("http://192.168.10.2:8080") one of ours, if `host` is the Host of its
/// request? It may have come through a proxy that does TLS.
bool is_same_origin(std::string_view origin, std::string_view host);

/// Why this request over the Unix socket is refused, or nothing. No page is served there: a browser
/// reaches it only through a tunnel, and names no origin for what the page itself asks.
std::optional<Refusal> refused_over_socket(const boost::beast::http::request_header<>& request);

/// Why this request over TCP is refused, or nothing.
std::optional<Refusal> refused_over_tcp(const boost::beast::http::request_header<>& request,
                                        const std::vector<std::string>& hosts);

}  // namespace mbgate::app
