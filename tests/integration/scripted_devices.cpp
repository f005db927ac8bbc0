// SPDX-License-Identifier: Apache-2.0
#include "integration/scripted_devices.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

#include "integration/process.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kRequestSize = 8;
constexpr auto kEmission = 700us;  // of a request at 115200 baud
constexpr auto kUsualDelay = 2ms;
constexpr auto kShown = 100ms;  // whatever was written by then
constexpr int kIdleWait = 20;

unsigned crc_of(const std::vector<unsigned char>& bytes, std::size_t size) {
  unsigned crc = 0xFFFF;
  for (std::size_t at = 0; at < size; ++at) {
    crc ^= bytes[at];
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 1U) != 0 ? (crc >> 1U) ^ 0xA001U : crc >> 1U;
    }
  }
  return crc;
}

unsigned word_at(const std::vector<unsigned char>& bytes, std::size_t at) {
  return unsigned{bytes[at]} << 8U | bytes[at + 1];
}

}  // namespace

ScriptedDevices::ScriptedDevices(int lines) {
  for (int at = 0; at < lines; ++at) {
    Line& line = lines_.emplace_back();
    char name[64];
    if (openpty(&line.far, &line.near, name, nullptr, nullptr) != 0) {
      throw std::runtime_error("no pty");
    }
    termios raw{};
    tcgetattr(line.near, &raw);
    cfmakeraw(&raw);
    tcsetattr(line.near, TCSANOW, &raw);
    fcntl(line.far, F_SETFL, O_NONBLOCK);
    line.path = name;
  }
  thread_ = std::thread([this] { serve(); });
}

ScriptedDevices::~ScriptedDevices() {
  stop_ = true;
  thread_.join();
  for (const Line& line : lines_) {
    close(line.far);
    close(line.near);
  }
}

std::string ScriptedDevices::path(int line) const {
  return lines_[static_cast<std::size_t>(line)].path;
}

void ScriptedDevices::plan(int line, unsigned address, std::deque<Delay> delays) {
  const std::lock_guard lock(mutex_);
  Line& planned = lines_[static_cast<std::size_t>(line)];
  planned.to_come += static_cast<unsigned>(
      std::ranges::count_if(delays, [](const Delay& delay) { return delay.has_value(); }));
  planned.plans[address] = std::move(delays);
}

bool ScriptedDevices::all_given(int line) {
  std::unique_lock lock(mutex_);
  return planned_given_.wait_for(
      lock, kPatience, [&] { return lines_[static_cast<std::size_t>(line)].to_come == 0; });
}

std::optional<ScriptedDevices::Clock::time_point> ScriptedDevices::readable_at(int line) {
  const std::lock_guard lock(mutex_);
  return lines_[static_cast<std::size_t>(line)].readable_at;
}

unsigned ScriptedDevices::requests(int line) const {
  return lines_[static_cast<std::size_t>(line)].requests;
}

void ScriptedDevices::serve() {
  std::vector<pollfd> watched;
  watched.reserve(lines_.size());
  for (const Line& line : lines_) {
    watched.push_back({line.far, POLLIN, 0});
  }
  while (!stop_) {
    poll(watched.data(), watched.size(), wait_ms());
    for (Line& line : lines_) {
      read_requests(line);
      if (line.watch) {
        watch_planned(line);
      }
      answer_due(line);
    }
  }
}

// Until the next answer is due, to the millisecond before it.
int ScriptedDevices::wait_ms() const {
  int wait = kIdleWait;
  for (const Line& line : lines_) {
    wait = line.watch ? 0 : wait;
    if (!line.pending.empty()) {
      const auto left = line.pending.front().due - Clock::now();
      const auto whole = std::chrono::floor<std::chrono::milliseconds>(left).count();
      wait = std::clamp(static_cast<int>(whole), 0, wait);
    }
  }
  return wait;
}

void ScriptedDevices::read_requests(Line& line) {
  unsigned char buffer[256];
  const ssize_t count = read(line.far, buffer, sizeof buffer);
  if (count > 0) {
    line.received.insert(line.received.end(), buffer, buffer + count);
  }
  while (line.received.size() >= kRequestSize) {
    take_request(line);
    line.received.erase(line.received.begin(), line.received.begin() + kRequestSize);
  }
}

void ScriptedDevices::take_request(Line& line) {
  const auto& bytes = line.received;
  const unsigned crc = crc_of(bytes, 6);
  if (bytes[1] != 0x03 || bytes[6] != (crc & 0xFFU) || bytes[7] != crc >> 8U) {
    return;
  }
  const unsigned number = ++line.requests;
  const unsigned address = word_at(bytes, 2);
  const unsigned count = word_at(bytes, 4);
  Delay delay = kUsualDelay;
  bool is_planned = false;
  {
    const std::lock_guard lock(mutex_);
    auto& delays = line.plans[address];
    is_planned = !delays.empty();
    if (is_planned) {
      delay = delays.front();
      delays.pop_front();
    }
  }
  if (!delay) {
    return;
  }
  std::vector<unsigned char> frame{bytes[0], 0x03, static_cast<unsigned char>(2 * count)};
  for (unsigned at = 0; at < count; ++at) {
    const unsigned value = address == kRequests ? number : value_of(address + at);
    frame.push_back(static_cast<unsigned char>(value >> 8U));
    frame.push_back(static_cast<unsigned char>(value & 0xFFU));
  }
  const unsigned check = crc_of(frame, frame.size());
  frame.push_back(static_cast<unsigned char>(check & 0xFFU));
  frame.push_back(static_cast<unsigned char>(check >> 8U));
  auto due = Clock::now() + kEmission + *delay;
  if (!line.pending.empty()) {
    due = std::max(due, line.pending.back().due);
  }
  line.pending.push_back({due, std::move(frame), is_planned, number});
}

void ScriptedDevices::answer_due(Line& line) {
  const auto now = Clock::now();
  if (holds_) {
    for (Pending& answer : line.pending) {
      answer.due = std::max(answer.due, now + 1ms);
    }
    return;
  }
  while (!line.pending.empty() && line.pending.front().due <= now) {
    const Pending& answer = line.pending.front();
    if (write(line.far, answer.frame.data(), answer.frame.size()) !=
        static_cast<ssize_t>(answer.frame.size())) {
      throw std::runtime_error("a pty takes no answer");
    }
    if (answer.is_planned) {
      line.watch = {answer.request, now};
    }
    line.pending.pop_front();
  }
}

// The kernel hands bytes over when it comes to it; what it does not show was read at once.
void ScriptedDevices::watch_planned(Line& line) {
  const bool is_asked = line.requests != line.watch->request || !line.received.empty();
  int bytes = 0;
  ioctl(line.near, FIONREAD, &bytes);
  const auto now = Clock::now();  // not before: the kernel has them by then
  if (!is_asked && bytes == 0 && now < line.watch->since + kShown) {
    return;
  }
  const std::lock_guard lock(mutex_);
  line.readable_at = is_asked ? std::nullopt : std::optional(now);
  --line.to_come;
  line.watch.reset();
  planned_given_.notify_all();
}

}  // namespace mbgate::test
