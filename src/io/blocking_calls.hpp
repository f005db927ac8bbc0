// SPDX-License-Identifier: Apache-2.0
// Runs calls that may block for seconds, each on a thread of its own, so that one failing adapter
// delays nothing else. The results are posted back to the io thread. Between calls no thread
// exists.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <csignal>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace mbgate::io {

/// For threads beside the io thread: signals belong to that one, and here they would cut open() or
/// write() short.
inline void block_signals() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

class BlockingCalls {
 public:
  explicit BlockingCalls(boost::asio::io_context& context)
      : home_(std::make_shared<Home>(&context)) {}
  BlockingCalls(const BlockingCalls&) = delete;
  BlockingCalls& operator=(const BlockingCalls&) = delete;
  /// Does not wait: a call that is still blocked ends by itself, and its result is dropped.
  ~BlockingCalls() {
    const std::lock_guard lock(home_->mutex);
    home_->context = nullptr;
  }

  /// Runs `call` on a thread of its own, then `then(result)` on the io thread. False if no thread
  /// can be started; `call` is then destroyed without having run.
  template <typename Call, typename Then>
  [[nodiscard]] bool run(Call call, Then then) {
    try {
      std::thread([home = home_, call = std::move(call), then = std::move(then)]() mutable {
        block_signals();
        auto result = call();
        const std::lock_guard lock(home->mutex);
        if (home->context != nullptr) {
          boost::asio::post(*home->context,
                            [then = std::move(then), result = std::move(result)]() mutable {
                              then(std::move(result));
                            });
        }
      }).detach();
    } catch (const std::system_error&) {
      return false;
    }
    return true;
  }

 private:
  /// Taken only for the moment of posting and at the end of the process, never while a call blocks.
  struct Home {
    explicit Home(boost::asio::io_context* io) : context(io) {}
    std::mutex mutex;
    boost::asio::io_context* context;
  };

  std::shared_ptr<Home> home_;
};

}  // namespace mbgate::io
