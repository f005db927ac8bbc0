// SPDX-License-Identifier: Apache-2.0
#include "app/control/control.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/post.hpp>
#include <chrono>
#include <exception>
#include <fmt/core.h>
#include <new>
#include <utility>

#include "app/control/control_doors.hpp"
#include "io/blocking_calls.hpp"
#include "io/clock.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::app {

namespace {

using boost::asio::ip::tcp;
using UnixAcceptor = boost::asio::local::stream_protocol::acceptor;

/// Batches of the trace that may be on their way: one that is being taken, and the next.
constexpr std::size_t kMostBatches = 2;

/// An operator sees no delay, and a busy bus has some ten transactions meanwhile.
constexpr std::chrono::milliseconds kBringInterval{50};

}  // namespace

Control::Control(boost::asio::io_context& gateway, ControlTarget& target)
    : gateway_(gateway), target_(target), trace_timer_(gateway) {}

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
  if (!path_.empty() && ::stat(path_.c_str(), &now) == 0 && now.st_dev == device_ &&
      now.st_ino == inode_) {
    ::unlink(path_.c_str());
  }
}

void Control::begin() {
  if (thread_.joinable()) {
    return;
  }
  home_ = std::make_shared<boost::asio::io_context>(1);
  // By the clock, so that the numbers of an earlier process are smaller.
  using std::chrono::milliseconds;
  reported_ = static_cast<std::uint64_t>(
      std::chrono::duration_cast<milliseconds>(std::chrono::system_clock::now().time_since_epoch())
          .count());
  const auto switch_trace = [this](bool on) {
    boost::asio::post(gateway_, [this, on] { set_traced(on); });
  };
  server_ = std::make_unique<ControlServer>(home_, gateway_, target_, reported_, switch_trace);
  server_->apply(settings_);
  server_->doors().set_end(end_);
  work_.emplace(home_->get_executor());
  try {
    thread_ = std::thread([this] { run(); });
  } catch (...) {
    server_.reset();
    work_.reset();
    throw;
  }
}

void Control::apply(const gateway::HttpSettings& settings) {
  settings_ = settings;
  if (server_ != nullptr) {
    boost::asio::post(*home_, [this, settings] { server_->apply(settings); });
  }
}

void Control::set_end(int end) {
  end_ = end;
  if (server_ != nullptr) {
    boost::asio::post(*home_, [this, end] { server_->doors().set_end(end); });
  }
}

// The gateway goes on without it, whatever is missing here: descriptors, threads, memory.
std::string Control::listen_at(const std::string& path) {
  try {
    begin();
    auto opened = open_control_socket(*home_, path);
    if (!opened) {
      return opened.error();
    }
    path_ = path;
    struct stat made {};
    if (::stat(path.c_str(), &made) == 0) {
      device_ = made.st_dev;
      inode_ = made.st_ino;
    }
    auto acceptor = std::make_shared<UnixAcceptor>(*std::move(opened));
    boost::asio::post(*home_, [this, acceptor] { server_->doors().open(acceptor); });
  } catch (const std::exception& exception) {
    remove_socket();
    return fmt::format("control socket {}: {}", path, exception.what());
  }
  return {};
}

// The socket moves from the context of the gateway's thread to that of its own.
std::string Control::listen_on(gateway::ListenerId id, tcp::acceptor acceptor) {
  try {
    begin();
    const auto protocol = acceptor.local_endpoint().protocol();
    sys::UniqueFd socket(acceptor.release());
    auto moved = std::make_shared<tcp::acceptor>(*home_);
    moved->assign(protocol, socket.get());
    socket.release();
    boost::asio::post(*home_, [this, id, moved] { server_->doors().open(id, moved); });
  } catch (const std::exception& exception) {
    return std::string("http: ") + exception.what();
  }
  return {};
}

void Control::leave(gateway::ListenerId id) {
  if (server_ != nullptr) {
    boost::asio::post(*home_, [this, id] { server_->doors().close(id); });
  }
}

void Control::close_clients(gateway::ListenerId id) {
  if (server_ != nullptr) {
    boost::asio::post(*home_, [this, id] { server_->doors().close_clients(id); });
  }
}

void Control::when_left(const std::function<void()>& then) {
  if (server_ == nullptr) {
    then();
    return;
  }
  boost::asio::post(*home_, [&gateway = gateway_, then] { boost::asio::post(gateway, then); });
}

void Control::tell(Level level, const std::string& text) {
  if (server_ == nullptr) {
    return;
  }
  const std::uint64_t id = ++reported_;
  if (waiting_ >= kKeptEvents) {
    return;  // readers see by the numbers that it is missing
  }
  ++waiting_;
  JournalEvent event{id, std::chrono::system_clock::now(), level, text};
  boost::asio::post(*home_, [this, event = std::move(event)]() mutable {
    --waiting_;
    server_->tell(std::move(event));
  });
}

void Control::set_traced(bool on) {
  if (std::exchange(is_traced_, on) == on) {
    return;
  }
  target_.set_traced(on);
  if (on) {
    wait_for_trace();
  } else {
    trace_timer_.cancel();
  }
}

void Control::wait_for_trace() {
  trace_timer_.expires_after(kBringInterval);
  trace_timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error && is_traced_) {
      bring_trace();
      wait_for_trace();
    }
  });
}

// As long as the other thread has not taken what was brought, records stay where they are, and the
// oldest are lost in the end.
void Control::bring_trace() {
  if (batches_ >= kMostBatches) {
    return;
  }
  auto taken = target_.take_trace();
  if (taken.records.empty() && taken.lost == 0) {
    return;
  }
  const auto since_zero =
      std::chrono::duration_cast<std::chrono::system_clock::duration>(io::now().time_since_epoch());
  TraceBatch batch{std::move(taken), std::chrono::system_clock::now() - since_zero};
  ++batches_;
  boost::asio::post(*home_, [this, batch = std::move(batch)]() mutable {
    --batches_;
    server_->trace(std::move(batch));
  });
}

void Control::run() {
  io::block_signals();
  while (!home_->stopped()) {
    try {
      home_->run();
    } catch (const std::exception& exception) {  // of one connection: the others go on
      report_failure(exception);
    }
  }
}

void Control::report_failure(const std::exception& exception) {
  try {
    boost::asio::post(gateway_, [&target = target_, why = std::string(exception.what())] {
      target.control_failed(why);
    });
  } catch (const std::bad_alloc&) {
    return;  // Not even for that: it remains untold.
  }
}

}  // namespace mbgate::app
