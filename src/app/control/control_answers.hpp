// SPDX-License-Identifier: Apache-2.0
// The types of requests to the HTTP interface and of their answers.
#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/json/object.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "app/metrics/metrics.hpp"
#include "gateway/status/status_report.hpp"

namespace mbgate::app {

using HttpRequest = boost::beast::http::request<boost::beast::http::string_body>;
using HttpResponse = boost::beast::http::response<boost::beast::http::string_body>;

/// `text` may name what a client has sent.
boost::json::object error_json(std::string_view text);
HttpResponse answer(const HttpRequest& request, boost::beast::http::status status,
                    const boost::json::object& json);
HttpResponse wrong_method(const HttpRequest& request, const char* allowed);

/// Of either form of a target: "/healthz" or "http://gateway:8080/healthz".
std::string_view path_of(const boost::beast::http::request_header<>& request);
std::string_view query_of(const HttpRequest& request);
/// The value of a header field; `field`: its name, or Beast's number for it.
template <typename Field>
std::optional<std::string_view> value_of(const boost::beast::http::request_header<>& request,
                                         Field field) {
  const auto found = request.find(field);
  return found == request.end() ? std::nullopt
                                : std::optional<std::string_view>(
                                      std::in_place, found->value().data(), found->value().size());
}

/// Did a command come to nothing? What a refused reload says stands in the journal.
bool is_command_failed(const HttpRequest& request, boost::beast::http::status status);
/// "POST /api/v1/reload was answered 403 Forbidden". What a client names is cut.
std::string denied_text(const HttpRequest& request, boost::beast::http::status status);

/// The status report as JSON (docs/api.yaml).
boost::json::object status_json(const gateway::StatusReport& report, const ProcessStatus& process);

}  // namespace mbgate::app
