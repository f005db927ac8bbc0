// SPDX-License-Identifier: Apache-2.0
// Serves the files of the status page over HTTP, with headers that tell a browser what the page may
// do. The page uses the interface of docs/api.yaml as any other client does.
//
// To change
// - the status page, in app/page: index.html has its parts, page.css its colours; its data: feed.js
//   reads them, main.js passes them on; its tables: overview.js, why.js, plot.js.
// - the timeline: history.js (what is kept), wire.js (a frame in instants and characters),
//   timeline_draw.js (the picture), timeline.js (moving, zooming, the table).
// - the trace: trace.js, decode.js; how a browser gets the page: page_answer, embed.cmake.
// - tests: of the page tests/integration/page_test.py, page_rules.py; of single modules
//   page_modules_test.py; its pictures: ./dev screenshots.
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
