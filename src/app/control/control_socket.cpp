// SPDX-License-Identifier: Apache-2.0
#include "app/control/control_socket.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <filesystem>

namespace mbgate::app {
namespace {

using boost::asio::local::stream_protocol;

constexpr mode_t kOwnerAndGroup = 0660;
constexpr int kBacklog = 64;

std::string sentence(const std::string& path, const std::string& why) {
  return "control socket " + path + ": " + why + "; mbgatectl status and reload do not work";
}

// A socket that nobody listens on any more refuses; one in use takes the connection.
bool is_in_use(boost::asio::io_context& context, const stream_protocol::endpoint& endpoint) {
  boost::system::error_code error;
  stream_protocol::socket probe(context);
  probe.connect(endpoint, error);
  return !error;
}

}  // namespace

Result<stream_protocol::acceptor, std::string> open_control_socket(boost::asio::io_context& context,
                                                                   const std::string& path) {
  // As long as the kernel takes them, without the final zero.
  if (path.size() >= sizeof(sockaddr_un::sun_path)) {
    return sentence(path, "the path is too long, expected less than " +
                              std::to_string(sizeof(sockaddr_un::sun_path)) + " characters");
  }
  const stream_protocol::endpoint endpoint(path);
  std::error_code no_status;
  if (std::filesystem::is_socket(path, no_status)) {
    if (is_in_use(context, endpoint)) {
      return sentence(path, "another mbgated has it; give each its own [http] socket");
    }
    ::unlink(path.c_str());
  }
  boost::system::error_code error;
  stream_protocol::acceptor acceptor(context);
  acceptor.open(endpoint.protocol(), error);
  if (!error) {
    acceptor.bind(endpoint, error);
  }
  if (!error && ::chmod(path.c_str(), kOwnerAndGroup) != 0) {
    error.assign(errno, boost::system::system_category());
  }
  if (!error) {
    acceptor.listen(kBacklog, error);
  }
  if (error) {
    return sentence(path, error.message());
  }
  return acceptor;
}

}  // namespace mbgate::app
