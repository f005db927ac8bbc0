// SPDX-License-Identifier: Apache-2.0
// Serves the files of the status page over HTTP, with headers that tell a browser what the page may
// do. The page uses the interface of docs/api.yaml as any other client does.
#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <optional>
#include <string_view>

namespace mbgate::app {

/// The answer to a request for "/" or "/page/NAME"; nothing if this path is none of the page's.
/// Other methods than GET and HEAD are answered with 405.
std::optional<boost::beast::http::response<boost::beast::http::string_body>> page_answer(
    const boost::beast::http::request<boost::beast::http::string_body>& request,
    std::string_view path);

}  // namespace mbgate::app
