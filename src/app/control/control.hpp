// SPDX-License-Identifier: Apache-2.0
// The HTTP interface to a running gateway, on the control socket: /api/v1/status,
// /api/v1/reload, /api/v1/clear-counters, /api/v1/events and /healthz (docs/api.yaml). It has a
// thread of its own. Questions are posted to the gateway's thread and answers are posted back as
// values, and lines of the journal are posted too, so that a reader never holds up a bus.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "app/control/control_server.hpp"
#include "app/log.hpp"

namespace mbgate::app {

class Control {
 public:
  /// `gateway`: the context of the gateway's thread, which must outlive this object and does not
  /// run any more when it is destroyed.
  Control(boost::asio::io_context& gateway, ControlTarget& target);
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;
  /// Ends the thread and removes the socket.
  ~Control();

  /// Listens at this path and starts to answer. Returns why not, or nothing.
  std::string start(const std::string& path);
  /// A line that the journal gets, for those who read along. To be called on the gateway's thread,
  /// which it never holds up; nothing before start() has succeeded.
  void tell(Level level, const std::string& text);

 private:
  void run();
  void remove_socket() const;

  boost::asio::io_context& gateway_;
  ControlTarget& target_;
  std::shared_ptr<boost::asio::io_context> home_;
  std::unique_ptr<ControlServer> server_;
  std::string path_;
  dev_t device_ = 0;  ///< of the socket in the file system
  ino_t inode_ = 0;
  std::uint64_t told_ = 0;                ///< lines, also those that were dropped
  std::atomic<std::size_t> waiting_ = 0;  ///< lines that the server's thread has not taken yet
  std::thread thread_;
};

}  // namespace mbgate::app
