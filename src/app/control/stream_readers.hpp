// SPDX-License-Identifier: Apache-2.0
// The clients of a stream of server-sent events. Used only on the thread of the HTTP interface.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/control/connection.hpp"

namespace mbgate::app {

class StreamReaders {
 public:
  /// There is something new for them.
  void wake();
  /// Sends what `next` gives, which is nothing if it is still to come, until the client goes or
  /// takes nothing for kClientLimit.
  boost::asio::awaitable<void> feed(ControlStream& stream, std::function<std::string()> next);

 private:
  struct Reader {
    explicit Reader(const ControlStream::executor_type& executor) : news(executor) {}
    boost::asio::steady_timer news;  ///< ends when there is something to send
    bool has_gone = false;
  };

  static void watch(ControlStream& stream, const std::shared_ptr<Reader>& reader);
  /// What `next` gives, once it gives something; nothing if the reader has gone, or something is to
  /// be sent nevertheless.
  static boost::asio::awaitable<std::string> wait_for_news(
      Reader& reader, const std::function<std::string()>& next);

  std::vector<std::weak_ptr<Reader>> readers_;  ///< feed() has them
};

}  // namespace mbgate::app
