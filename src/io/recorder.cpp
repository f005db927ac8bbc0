// SPDX-License-Identifier: Apache-2.0
#include "io/recorder.hpp"

#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "io/blocking_calls.hpp"

namespace mbgate::io {
namespace {

/// Lines are gathered for this long, or up to this size, before they are written together.
constexpr std::chrono::milliseconds kGatherTime{100};
constexpr std::size_t kGatherSize = 65536;

}  // namespace

/// What the two threads share. Nobody holds the lock while it writes, and the io thread never waits
/// for it but in close().
struct Recorder::Shared {
  explicit Shared(sys::UniqueFd descriptor) : file(std::move(descriptor)) {}
  sys::UniqueFd file;
  std::mutex mutex;
  std::condition_variable wake;
  std::condition_variable ended;
  std::string waiting;
  bool closing = false;
  bool done = false;
  int error = 0;
};

Recorder::Recorder(sys::UniqueFd file, const std::string& head, OnEnded on_ended)
    : shared_(std::make_shared<Shared>(std::move(file))),
      noted_(head),
      on_ended_(std::move(on_ended)) {
  std::thread([shared = shared_] { write_until_closed(shared); }).detach();
}

Recorder::~Recorder() {
  const std::lock_guard lock(shared_->mutex);
  shared_->closing = true;
  shared_->wake.notify_one();
}

void Recorder::write_until_closed(const std::shared_ptr<Shared>& shared) {
  block_signals();
  std::string writing;
  std::unique_lock lock(shared->mutex);
  while (shared->error == 0) {
    shared->wake.wait(lock, [&] { return shared->closing || !shared->waiting.empty(); });
    if (shared->waiting.empty()) {
      break;
    }
    writing.clear();
    writing.swap(shared->waiting);
    lock.unlock();
    const int error = sys::write_all(shared->file.get(), writing);
    lock.lock();
    shared->error = error;
    shared->wake.wait_for(lock, kGatherTime, [&] {
      return shared->closing || shared->error != 0 || shared->waiting.size() >= kGatherSize;
    });
  }
  shared->done = true;
  shared->ended.notify_one();
}

void Recorder::begin(gateway::Instant start) { report::append_start(noted_, start); }

void Recorder::note(const gateway::Input& input, gateway::Instant at) {
  if (!ended_) {
    report::append_line(noted_, input, at);
  }
}

void Recorder::note(const gateway::Action& action, const gateway::Settings& settings) {
  if (!ended_) {
    report::append_line(noted_, action, settings);
  }
}

void Recorder::hand_over() {
  if (noted_.empty()) {
    return;
  }
  const std::unique_lock lock(shared_->mutex, std::try_to_lock);
  if (!lock) {
    return;
  }
  if (shared_->error != 0) {
    fail("it cannot be written: " + std::generic_category().message(shared_->error));
  } else if (!ended_ && noted_.size() + shared_->waiting.size() > kMostWaiting) {
    fail("it cannot be written as fast as it grows");
  }
  give(*shared_);
}

// With the lock held.
void Recorder::give(Shared& shared) {
  const bool was_empty = shared.waiting.empty();
  if (was_empty) {
    shared.waiting.swap(noted_);
  } else {
    shared.waiting += noted_;
  }
  noted_.clear();
  if (was_empty || shared.waiting.size() >= kGatherSize) {
    shared.wake.notify_one();
  }
}

void Recorder::end(const std::string& why) {
  if (!ended_) {
    report::append_end(noted_, why);
    ended_ = true;
  }
}

void Recorder::fail(const std::string& why) {
  if (!ended_) {
    end(why);
    on_ended_(why);
  }
}

bool Recorder::close(std::chrono::milliseconds limit) {
  ended_ = true;
  std::unique_lock lock(shared_->mutex);
  give(*shared_);
  shared_->closing = true;
  shared_->wake.notify_one();
  return shared_->ended.wait_for(lock, limit, [this] { return shared_->done; }) &&
         shared_->error == 0;
}

}  // namespace mbgate::io
