// SPDX-License-Identifier: Apache-2.0
// The HTTP interface to a running gateway, on the control socket and TCP: /api/v1/status, events,
// trace, reload and clear-counters, /healthz, and the status page (docs/api.yaml). It has a thread
// of its own. Questions are posted to the gateway's thread and answers are posted back as values,
// and lines of the journal are posted too, so that a reader never holds up a bus.
//
// To change
// - the requests that the control socket accepts: control, docs/api.yaml; their execution:
//   ControlTarget, in app/service; the identity and the rate of the asker: asker, control_doors.
// - the requests and clients that are accepted over TCP: tcp_rules, control_doors; the length of a
//   request: request_reader; the connection that makes room for another: http_places; addresses:
//   app/http_listeners; config/sections/http_section.
// - the stream of the journal's events: the choice of lines: Log::give() in app/log, the only
//   place; the way to the thread of the control socket: Control::tell(); storage, sending and
//   number of readers: event_streams, docs/api.yaml; mbgatectl: ctl/control/event_reader.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "app/control/control_server.hpp"
#include "app/log.hpp"
#include "gateway/settings.hpp"

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

  /// Sets who may read over TCP, and how many streams there may be: now or once it has begun.
  void apply(const gateway::HttpSettings& settings);
  /// The first descriptor that no client over TCP may have, now or once it has begun.
  void set_end(int end);
  /// Listens at this path. It begins to answer with the first socket of either kind. Returns why
  /// not, or nothing.
  std::string listen_at(const std::string& path);
  /// Takes this listening socket over. Returns why not, or nothing.
  std::string listen_on(gateway::ListenerId id, boost::asio::ip::tcp::acceptor acceptor);
  /// Closes the sockets of this number, soon. Who has connected there stays, until close_clients().
  void leave(gateway::ListenerId id);
  void close_clients(gateway::ListenerId id);
  /// Calls this on the gateway's thread when all that was left is closed.
  void when_left(const std::function<void()>& then);
  /// A line that the journal gets, for those who read along. To be called on the gateway's thread,
  /// which it never holds up; nothing before it answers.
  void tell(Level level, const std::string& text);

 private:
  /// While it is on, the trace is brought to the other thread several times a second.
  void set_traced(bool on);
  void wait_for_trace();
  void bring_trace();
  /// Has its thread and what runs there, once. Throws what the standard library throws.
  void begin();
  void run();
  void report_failure(const std::exception& exception);
  void remove_socket() const;

  boost::asio::io_context& gateway_;
  ControlTarget& target_;
  std::shared_ptr<boost::asio::io_context> home_;
  /// It has nothing to do while nobody listens.
  std::optional<boost::asio::executor_work_guard<boost::asio::io_context::executor_type>> work_;
  std::unique_ptr<ControlServer> server_;
  gateway::HttpSettings settings_;
  int end_ = std::numeric_limits<int>::max();
  std::string path_;
  dev_t device_ = 0;  ///< of the socket in the file system
  ino_t inode_ = 0;
  std::uint64_t reported_ = 0;            ///< lines, also those that were dropped
  std::atomic<std::size_t> waiting_ = 0;  ///< lines that the server's thread has not taken yet
  std::atomic<std::size_t> batches_ = 0;  ///< of the trace, not taken yet either
  boost::asio::steady_timer trace_timer_;
  bool is_traced_ = false;
  std::thread thread_;
};

}  // namespace mbgate::app
