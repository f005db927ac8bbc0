// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/control_shell.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/json/parse.hpp>
#include <cerrno>
#include <thread>

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

/// How long a wish to give up goes unnoticed.
constexpr std::chrono::milliseconds kLook{50};

/// A request that is sent, and the response that comes, as far as they have got.
class Exchange {
 public:
  Exchange(stream_protocol::socket& connection, const std::string& method,
           const std::string& target)
      : connection_(connection), request_(http::string_to_verb(method), target, 11) {
    request_.set(http::field::host, "mbgated");
    request_.set(http::field::connection, "close");
    request_.prepare_payload();
  }

  void start() {
    http::async_write(connection_, request_,
                      [this](const boost::system::error_code& error, std::size_t /*bytes*/) {
                        error_ = error;
                        if (!error) {
                          read();
                        }
                      });
  }

  [[nodiscard]] const boost::system::error_code& error() const { return error_; }
  [[nodiscard]] const http::response<http::string_body>& response() const { return response_; }

 private:
  void read() {
    http::async_read(
        connection_, buffer_, response_,
        [this](const boost::system::error_code& error, std::size_t /*bytes*/) { error_ = error; });
  }

  stream_protocol::socket& connection_;
  http::request<http::empty_body> request_;
  boost::beast::flat_buffer buffer_;
  http::response<http::string_body> response_;
  boost::system::error_code error_;
};

/// How long the answer is waited for.
struct Patience {
  std::chrono::steady_clock::time_point end;
  const std::function<bool()>& give_up;

  [[nodiscard]] bool is_over() const {
    return std::chrono::steady_clock::now() >= end || (give_up && give_up());
  }
};

/// A Unix socket is connected at once, or its queue is full because mbgated hangs: then the kernel
/// would wait without end.
boost::system::error_code connect(stream_protocol::socket& connection, const std::string& path,
                                  const Patience& patience) {
  const stream_protocol::endpoint endpoint(path);
  boost::system::error_code error;
  connection.open(endpoint.protocol(), error);
  if (!error) {
    connection.native_non_blocking(true, error);
  }
  while (!error) {
    if (::connect(connection.native_handle(), endpoint.data(),
                  static_cast<socklen_t>(endpoint.size())) == 0) {
      break;
    }
    if (errno != EAGAIN) {
      error.assign(errno, boost::system::system_category());
    } else if (patience.is_over()) {
      error = boost::asio::error::timed_out;
    } else {
      std::this_thread::sleep_for(kLook);
    }
  }
  return error;
}

/// Runs what was started, to its end or that of the patience.
void run(boost::asio::io_context& context, const Patience& patience) {
  while (!context.stopped() && !patience.is_over()) {
    context.run_until(std::min(patience.end, std::chrono::steady_clock::now() + kLook));
  }
}

}  // namespace

std::string error_of(const ControlAnswer& answer) {
  const auto* const error = answer.json.if_contains("error");
  return error != nullptr && error->is_string()
             ? std::string(error->get_string())
             : "unexpected answer, HTTP status " + std::to_string(answer.status);
}

Result<ControlAnswer, std::string> ask_control(const std::string& socket, const std::string& method,
                                               const std::string& target,
                                               std::chrono::seconds limit,
                                               const std::function<bool()>& give_up) {
  if (socket.size() >= sizeof(sockaddr_un::sun_path)) {
    return socket + ": the path of a socket has at most " +
           std::to_string(sizeof(sockaddr_un::sun_path) - 1) + " characters";
  }
  const Patience patience{std::chrono::steady_clock::now() + limit, give_up};
  boost::asio::io_context context;
  stream_protocol::socket connection(context);
  boost::system::error_code error = connect(connection, socket, patience);
  Exchange exchange(connection, method, target);
  if (!error) {
    exchange.start();
    run(context, patience);
    error = context.stopped() ? exchange.error() : boost::asio::error::timed_out;
  }
  if (error == boost::asio::error::timed_out) {
    return "mbgated has not answered within " + std::to_string(limit.count()) + " s";
  }
  if (error) {
    return explain(socket, error);
  }
  const auto json = boost::json::parse(exchange.response().body(), error);
  if (error || !json.is_object()) {
    return socket + ": what answers there is not mbgated";
  }
  return ControlAnswer{exchange.response().result_int(), json.get_object()};
}

}  // namespace mbgate::ctl
