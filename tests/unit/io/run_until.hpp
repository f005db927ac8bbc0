// SPDX-License-Identifier: Apache-2.0
// Runs an io_context until something has happened, with a limit that only a failing test reaches.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>

namespace mbgate::io {

/// False if `happened` is still false after a minute.
inline bool run_until(boost::asio::io_context& context, const std::function<bool()>& happened) {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!happened()) {
    if (std::chrono::steady_clock::now() >= limit) {
      return false;
    }
    context.restart();
    context.run_one_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace mbgate::io
