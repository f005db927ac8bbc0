// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/control_shell.hpp"

#include <sys/un.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/json/parse.hpp>

namespace mbgate::ctl {
namespace {

namespace http = boost::beast::http;
using boost::asio::local::stream_protocol;

std::string explain(const std::string& socket, const boost::system::error_code& error) {
  if (error == boost::system::errc::no_such_file_or_directory) {
    return "there is no control socket at " + socket +
           ": is mbgated running (systemctl status mbgated)? Where [http] socket names another "
           "path, give it with --control";
  }
  if (error == boost::system::errc::permission_denied) {
    return "no permission for " + socket + ": run it as root, or as a member of its group";
  }
  if (error == boost::system::errc::connection_refused) {
    return "nobody listens at " + socket + " any more: mbgated has ended (journalctl -u mbgated)";
  }
  return socket + ": " + error.message();
}

}  // namespace

Result<ControlAnswer, std::string> ask_control(const std::string& socket, const std::string& method,
                                               const std::string& target,
                                               std::chrono::seconds limit) {
  if (socket.size() >= sizeof(sockaddr_un::sun_path)) {
    return socket + ": the path of a socket has at most " +
           std::to_string(sizeof(sockaddr_un::sun_path) - 1) + " characters";
  }
  boost::asio::io_context context;
  boost::beast::basic_stream<stream_protocol> connection(context);
  http::request<http::empty_body> request(http::string_to_verb(method), target, 11);
  request.set(http::field::host, "mbgated");
  request.set(http::field::connection, "close");
  request.prepare_payload();
  boost::beast::flat_buffer buffer;
  http::response<http::string_body> response;
  boost::system::error_code error;
  const auto note = [&](const boost::system::error_code& ended, std::size_t /*bytes*/) {
    error = ended;
  };
  connection.expires_after(limit);
  connection.async_connect(stream_protocol::endpoint(socket),
                           [&](const boost::system::error_code& ended) { note(ended, 0); });
  context.run();
  if (!error) {
    context.restart();
    http::async_write(connection, request, note);
    context.run();
  }
  if (!error) {
    context.restart();
    http::async_read(connection, buffer, response, note);
    context.run();
  }
  if (error == boost::beast::error::timeout) {
    return "mbgated has not answered within " + std::to_string(limit.count()) + " s";
  }
  if (error) {
    return explain(socket, error);
  }
  const auto json = boost::json::parse(response.body(), error);
  if (error || !json.is_object()) {
    return socket + ": what answers there is not mbgated";
  }
  return ControlAnswer{response.result_int(), json.get_object()};
}

}  // namespace mbgate::ctl
