// SPDX-License-Identifier: Apache-2.0
// A TcpLine and its far end on loopback.
#pragma once

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include "io/lines/tcp_line.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::io {

using boost::asio::ip::tcp;

inline const std::array<std::uint8_t, 4> kFrame{1, 2, 3, 4};
inline const std::string kFrameText{1, 2, 3, 4};
/// 127.0.0.1 in a form that only the system's resolver understands: to the line it is a name, and
/// no machine needs to know it.
inline const std::string kName = "127.1";
/// The far end: its connections are taken when the test wants it.
class FarEnd {
 public:
  explicit FarEnd(boost::asio::io_context& context, int backlog = 16) : acceptor_(context) {
    acceptor_.open(tcp::v4());
    acceptor_.set_option(tcp::acceptor::reuse_address(true));
    acceptor_.bind({boost::asio::ip::address_v4::loopback(), 0});
    acceptor_.listen(backlog);
    port_ = acceptor_.local_endpoint().port();
  }

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Waits for a connection that the line makes.
  tcp::socket& accept() { return peers_.emplace_back(acceptor_.accept()); }
  [[nodiscard]] bool has_waiting() {
    pollfd watched{acceptor_.native_handle(), POLLIN, 0};
    return ::poll(&watched, 1, 0) > 0;
  }
  void stop_listening() { acceptor_.close(); }

 private:
  tcp::acceptor acceptor_;
  std::list<tcp::socket> peers_;
  std::uint16_t port_ = 0;
};

/// What has come, without waiting.
inline std::string receive(tcp::socket& peer) {
  std::string bytes(65536, '\0');
  const ssize_t count = ::recv(peer.native_handle(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return bytes;
}

class TcpLineTest : public testing::Test, public LineEvents {
 protected:
  void line_opened(drive::BusId /*bus*/, bus::LineKind /*kind*/,
                   const std::vector<std::string>& warnings) override {
    ++opened_;
    warnings_ = warnings;
  }
  void line_bytes(drive::BusId /*bus*/, modbus::Bytes bytes) override {
    received_.append(bytes.begin(), bytes.end());
    longest_piece_ = std::max(longest_piece_, bytes.size());
  }
  void line_unsent(drive::BusId /*bus*/, std::size_t /*bytes*/) override { FAIL(); }
  void line_lost(drive::BusId /*bus*/, const std::string& why) override { lost_.push_back(why); }
  void line_closed(drive::BusId /*bus*/, const std::string& why) override {
    closed_.push_back(why);
  }

  void make_line(const std::string& host, std::uint16_t port) {
    bus::LineSettings line;
    line.remote = {host, port};
    line.connection = times_;
    line_.emplace(LineContext{context_, blocking_, *this}, drive::BusId{0}, line);
  }
  bool wait_for(const std::function<bool()>& happened) { return run_until(context_, happened); }
  /// The far end of a line that has been opened.
  tcp::socket* connect(FarEnd& far) {
    const int before = opened_;
    line_->open();
    return wait_for([&] { return opened_ > before; }) ? &far.accept() : nullptr;
  }
  static std::string name_of(std::uint16_t port) {
    return "tcp://127.0.0.1:" + std::to_string(port);
  }

  boost::asio::io_context context_;
  BlockingCalls blocking_{context_};
  std::optional<TcpLine> line_;
  int opened_ = 0;
  std::vector<std::string> warnings_;
  std::vector<std::string> lost_;
  std::vector<std::string> closed_;
  bus::ConnectionTimes times_;
  std::string received_;
  std::size_t longest_piece_ = 0;
};

}  // namespace mbgate::io
