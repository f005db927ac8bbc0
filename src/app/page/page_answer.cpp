// SPDX-License-Identifier: Apache-2.0
#include "app/page/page_answer.hpp"

#include <algorithm>
#include <boost/beast/http/field.hpp>
#include <fmt/core.h>
#include <string>

namespace mbgate::app {
namespace {

namespace http = boost::beast::http;
using PageResponse = http::response<http::string_body>;

constexpr std::string_view kFolder = "/page/";
constexpr std::string_view kFirstFile = "index.html";
/// Nothing but what comes from here, and nowhere in a frame: names in a configuration and what
/// devices say of themselves are text, whatever they look like.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const PageFile* find_file(std::string_view path) {
  if (path == "/") {
    path = kFirstFile;
  } else if (path.starts_with(kFolder)) {
    path.remove_prefix(kFolder.size());
  } else {
    return nullptr;
  }
  const auto files = page_files();
  const auto found = std::ranges::find(files, path, &PageFile::name);
  return found == files.end() ? nullptr : &*found;
}

const char* type_of(std::string_view name) {
  if (name.ends_with(".html")) {
    return "text/html; charset=utf-8";
  }
  if (name.ends_with(".css")) {
    return "text/css; charset=utf-8";
  }
  return name.ends_with(".svg") ? "image/svg+xml" : "text/javascript; charset=utf-8";
}

PageResponse wrong_method(const http::request<http::string_body>& request) {
  PageResponse response(http::status::method_not_allowed, request.version());
  response.set(http::field::content_type, "application/json");
  response.set(http::field::allow, "GET, HEAD");
  response.body() = "{\"error\":\"expected GET or HEAD\"}\n";
  return response;
}

}  // namespace

// A browser asks again each time whether a file is still the same, and gets it only if it is not: a
// page of an earlier version would not understand what this one says.
std::optional<PageResponse> page_answer(const http::request<http::string_body>& request,
                                        std::string_view path) {
  const PageFile* file = find_file(path);
  if (file == nullptr) {
    return std::nullopt;
  }
  PageResponse response(http::status::ok, request.version());
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    response = wrong_method(request);
  } else {
    const std::string tag = fmt::format("\"{}\"", file->hash);
    response.set(http::field::etag, tag);
    response.set(http::field::cache_control, "no-cache");
    response.set(http::field::content_type, type_of(file->name));
    response.set("Content-Security-Policy", kPolicy);
    response.set("Referrer-Policy", "no-referrer");
    if (request[http::field::if_none_match] == tag) {
      response.result(http::status::not_modified);
    } else {
      response.body() = file->content;
    }
  }
  response.set("X-Content-Type-Options", "nosniff");
  response.keep_alive(request.keep_alive());
  response.prepare_payload();
  return response;
}

}  // namespace mbgate::app
