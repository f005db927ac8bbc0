// SPDX-License-Identifier: Apache-2.0
#include "app/control/control.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/post.hpp>
#include <chrono>
#include <exception>
#include <utility>

#include "app/control/control_socket.hpp"
#include "io/blocking_calls.hpp"
#include "io/supervise.hpp"

namespace mbgate::app {

Control::Control(boost::asio::io_context& gateway, ControlTarget& target)
    : gateway_(gateway), target_(target) {}

Control::~Control() {
  if (!thread_.joinable()) {
    return;
  }
  home_->stop();
  thread_.join();
  remove_socket();
  server_.reset();
}

// Only the own one: another process may have put its socket there since.
void Control::remove_socket() const {
  struct stat now {};
  if (::stat(path_.c_str(), &now) == 0 && now.st_dev == device_ && now.st_ino == inode_) {
    ::unlink(path_.c_str());
  }
}

// The gateway goes on without it, whatever is missing here: descriptors, threads, memory.
std::string Control::start(const std::string& path) {
  try {
    home_ = std::make_shared<boost::asio::io_context>(1);
    auto acceptor = open_control_socket(*home_, path);
    if (!acceptor) {
      return acceptor.error();
    }
    path_ = path;
    struct stat made {};
    if (::stat(path.c_str(), &made) == 0) {
      device_ = made.st_dev;
      inode_ = made.st_ino;
    }
    // By the clock, so that the numbers of an earlier process are smaller.
    using std::chrono::milliseconds;
    told_ = static_cast<std::uint64_t>(std::chrono::duration_cast<milliseconds>(
                                           std::chrono::system_clock::now().time_since_epoch())
                                           .count());
    server_ =
        std::make_unique<ControlServer>(home_, gateway_, target_, *std::move(acceptor), told_);
    io::supervise(*home_, server_->accept(), "control");
    thread_ = std::thread([this] { run(); });
  } catch (const std::exception& exception) {
    remove_socket();
    server_.reset();
    return "control socket " + path + ": " + exception.what();
  }
  return {};
}

void Control::tell(Level level, const std::string& text) {
  if (server_ == nullptr) {
    return;
  }
  const std::uint64_t id = ++told_;
  if (waiting_ >= EventRing::kSize) {
    return;  // readers see by the numbers that it is missing
  }
  ++waiting_;
  JournalEvent event{id, std::chrono::system_clock::now(), level, text};
  boost::asio::post(*home_, [this, event = std::move(event)]() mutable {
    --waiting_;
    server_->tell(std::move(event));
  });
}

void Control::run() {
  io::block_signals();
  while (!home_->stopped()) {
    try {
      home_->run();
    } catch (const std::exception& exception) {  // of one connection: the others go on
      boost::asio::post(gateway_, [&target = target_, why = std::string(exception.what())] {
        target.control_failed(why);
      });
    }
  }
}

}  // namespace mbgate::app
