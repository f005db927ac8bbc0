// SPDX-License-Identifier: Apache-2.0
#include "app/control/control_answers.hpp"

#include <algorithm>
#include <boost/beast/http.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/core.h>

#include "app/text.hpp"

namespace mbgate::app {

namespace http = boost::beast::http;

boost::json::object error_json(std::string_view text) { return {{"error", valid_utf8(text)}}; }

HttpResponse answer(const HttpRequest& request, http::status status,
                    const boost::json::object& json) {
  HttpResponse response(status, request.version());
  response.set(http::field::content_type, "application/json");
  response.set(http::field::cache_control, "no-store");
  response.keep_alive(request.keep_alive());
  if (status == http::status::too_many_requests) {
    response.set(http::field::retry_after, "1");
  }
  response.body() = boost::json::serialize(json) + "\n";
  response.prepare_payload();
  return response;
}

std::string_view path_of(const http::request_header<>& request) {
  std::string_view target(request.target().data(), request.target().size());
  constexpr std::string_view kScheme = "http://";
  if (target.starts_with(kScheme)) {  // the absolute form (RFC 9112, 3.2.2)
    target.remove_prefix(std::min(target.find('/', kScheme.size()), target.size()));
  }
  return target.substr(0, target.find('?'));
}

std::string_view query_of(const HttpRequest& request) {
  const std::string_view target(request.target().data(), request.target().size());
  const std::size_t mark = target.find('?');
  return mark == std::string_view::npos ? std::string_view() : target.substr(mark + 1);
}

HttpResponse wrong_method(const HttpRequest& request, const char* allowed) {
  HttpResponse response = answer(request, http::status::method_not_allowed,
                                 error_json(std::string("expected ") + allowed));
  response.set(http::field::allow, allowed);
  return response;
}

bool is_command_failed(const HttpRequest& request, http::status status) {
  return request.method() == http::verb::post && status >= http::status::bad_request &&
         status != http::status::unprocessable_entity;
}

std::string denied_text(const HttpRequest& request, http::status status) {
  constexpr std::size_t kLongest = 64;
  return fmt::format("POST {} was answered {} {}", valid_utf8(path_of(request).substr(0, kLongest)),
                     static_cast<unsigned>(status), http::obsolete_reason(status));
}

}  // namespace mbgate::app
