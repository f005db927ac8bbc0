// SPDX-License-Identifier: Apache-2.0
#include "io/supervise.hpp"

#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <fmt/core.h>
#include <stdexcept>
#include <utility>

namespace mbgate::io {

void supervise(boost::asio::io_context& context, boost::asio::awaitable<void> coroutine,
               const char* name) {
  boost::asio::co_spawn(context, std::move(coroutine), [name](const std::exception_ptr& error) {
    if (!error) {
      return;
    }
    try {
      std::rethrow_exception(error);
    } catch (const std::exception& exception) {
      throw std::runtime_error(fmt::format("{}: {}", name, exception.what()));
    }
  });
}

}  // namespace mbgate::io
