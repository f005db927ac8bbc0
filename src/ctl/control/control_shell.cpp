// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/control_shell.hpp"

#include <sys/socket.h>
#include <sys/time.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
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

void set_limit(stream_protocol::socket& socket, std::chrono::seconds limit) {
  const timeval time{limit.count(), 0};
  for (const int option : {SO_RCVTIMEO, SO_SNDTIMEO}) {
    ::setsockopt(socket.native_handle(), SOL_SOCKET, option, &time, sizeof time);
  }
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
  stream_protocol::socket connection(context);
  boost::system::error_code error;
  connection.connect(stream_protocol::endpoint(socket), error);
  if (error) {
    return explain(socket, error);
  }
  set_limit(connection, limit);
  http::request<http::empty_body> request(http::string_to_verb(method), target, 11);
  request.set(http::field::host, "mbgated");
  request.set(http::field::connection, "close");
  request.prepare_payload();
  http::write(connection, request, error);
  boost::beast::flat_buffer buffer;
  http::response<http::string_body> response;
  if (!error) {
    http::read(connection, buffer, response, error);
  }
  if (error == boost::asio::error::would_block || error == boost::asio::error::try_again) {
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
