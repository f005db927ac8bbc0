// SPDX-License-Identifier: Apache-2.0
// Serves the files of the status page over HTTP, with headers that tell a browser what the page may
// do. The page uses the interface of docs/api.yaml as any other client does.
#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <optional>
#include <span>
#include <string_view>

namespace mbgate::app {

/// The answer to a request for "/" or "/page/NAME"; nothing if this path is none of the page's.
/// Other methods than GET and HEAD are answered with 405.
std::optional<boost::beast::http::response<boost::beast::http::string_body>> page_answer(
    const boost::beast::http::request<boost::beast::http::string_body>& request,
    std::string_view path);

/// The files of the status page, as they are in this folder. CMake puts them into the program
/// (embed.cmake), so that it needs no folder of its own when it runs.
struct PageFile {
  std::string_view name;  ///< "page.css"
  std::string_view content;
  std::string_view hash;  ///< of its content: another one after any change
};

std::span<const PageFile> page_files();

}  // namespace mbgate::app
