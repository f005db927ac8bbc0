// SPDX-License-Identifier: Apache-2.0
#include "app/control/control_socket.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <cerrno>
#include <filesystem>

#include "io/advice.hpp"

namespace mbgate::app {
namespace {

using boost::asio::local::stream_protocol;

constexpr mode_t kOwnerAndGroup = 0660;
constexpr int kBacklog = 64;

std::string sentence(const std::string& path, const std::string& why) {
  return "control socket " + path + ": " + why +
         "; mbgatectl status, reload and events do not work";
}

// Only a socket that nobody listens on any more refuses. Whatever else comes of it, somebody has
// it.
bool is_left_over(boost::asio::io_context& context, const stream_protocol::endpoint& endpoint) {
  stream_protocol::socket probe(context, endpoint.protocol());
  probe.native_non_blocking(true);
  const auto* const address = endpoint.data();
  return ::connect(probe.native_handle(), address, static_cast<socklen_t>(endpoint.size())) != 0 &&
         errno == ECONNREFUSED;
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
    if (!is_left_over(context, endpoint)) {
      return sentence(path, "another process has it; give each mbgated its own [http] socket");
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
    const auto folder = std::filesystem::path(path).parent_path();
    return sentence(path, error.message() +
                              io::folder_advice(folder.empty() ? "." : folder.string(),
                                                error.value(), "choose a path below /run/mbgate"));
  }
  return acceptor;
}

}  // namespace mbgate::app
