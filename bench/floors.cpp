// SPDX-License-Identifier: Apache-2.0
#include "floors.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <span>
#include <system_error>
#include <thread>

#include "modbus/frames.hpp"
#include "moment.hpp"

namespace mbgate::bench {
namespace {

/// So long is waited for a response, as mbgated is told to: briefly where there are dead devices.
int response_timeout_ms(const Plant& plant) { return plant.dead > 0 ? 100 : 1000; }

/// A raw line, opened for both ways.
int open_line(const std::string& path) {
  const int line = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios mode{};
  if (line < 0 || ::tcgetattr(line, &mode) != 0) {
    throw std::system_error(errno, std::generic_category(), path);
  }
  ::cfmakeraw(&mode);
  ::tcsetattr(line, TCSANOW, &mode);
  return line;
}

/// The end of its response; the moment at which it was given up if there was none.
Moment receive_response(int line, std::size_t size, int timeout_ms) {
  std::array<std::uint8_t, 512> part{};
  for (std::size_t received = 0; received < size;) {
    pollfd descriptor{line, POLLIN, 0};
    if (::poll(&descriptor, 1, timeout_ms) <= 0) {
      break;
    }
    const ssize_t count = ::read(line, part.data(), part.size());
    if (count <= 0) {
      break;
    }
    received += static_cast<std::size_t>(count);
  }
  return Clock::now();
}

void master_of_line(const Plant& plant, const std::string& path) {
  want_exact_timers();
  const int line = open_line(path);
  std::vector<Frame> requests;
  for (unsigned address = 1; address <= plant.devices; ++address) {
    requests.push_back(make_request(address, 0, plant.registers));
  }
  for (std::size_t turn = 0;; turn = (turn + 1) % requests.size()) {
    if (::write(line, requests[turn].data(), requests[turn].size()) !=
        static_cast<ssize_t>(requests[turn].size())) {
      throw std::system_error(errno, std::generic_category(), path);
    }
    const Moment end =
        receive_response(line, response_size(plant.registers), response_timeout_ms(plant));
    if (plant.paced()) {
      sleep_until(end + plant.t3_5());
    }
  }
}

class Relay {
 public:
  Relay(const Plant& plant, const std::string& path, int listening)
      : plant_(plant), line_(open_line(path)), listening_(listening), epoll_(::epoll_create1(0)) {
    want_exact_timers();
    watch(line_);
    watch(listening_);
  }

  [[noreturn]] void run() {
    for (;;) {
      std::array<epoll_event, 64> events{};
      const int count = ::epoll_wait(epoll_, events.data(), events.size(), -1);
      for (int event = 0; event < count; ++event) {
        const int descriptor = events[static_cast<std::size_t>(event)].data.fd;
        if (descriptor == line_) {
          take_response();
        } else if (descriptor == listening_) {
          const int client = ::accept4(listening_, nullptr, nullptr, SOCK_NONBLOCK);
          const int on = 1;
          ::setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
          watch(client);
        } else {
          take_request(descriptor);
        }
      }
    }
  }

 private:
  struct Request {
    int client;
    std::array<std::uint8_t, 12> adu;
  };

  void watch(int descriptor) const {
    epoll_event event{EPOLLIN, {}};
    event.data.fd = descriptor;
    ::epoll_ctl(epoll_, EPOLL_CTL_ADD, descriptor, &event);
  }

  void take_request(int client) {
    Request request{client, {}};
    const ssize_t count = ::read(client, request.adu.data(), request.adu.size());
    if (count != static_cast<ssize_t>(request.adu.size())) {
      ::close(client);
      return;
    }
    waiting_.push_back(request);
    if (waiting_.size() == 1) {
      transmit();
    }
  }

  void transmit() const {
    const auto& adu = waiting_.front().adu;
    std::array<std::uint8_t, kRequestSize> frame{};
    std::copy(adu.begin() + 6, adu.end(), frame.begin());
    const unsigned crc = modbus::crc16(std::span(frame).first(6));
    frame[6] = static_cast<std::uint8_t>(crc & 0xFFU);
    frame[7] = static_cast<std::uint8_t>(crc >> 8U);
    if (::write(line_, frame.data(), frame.size()) != static_cast<ssize_t>(frame.size())) {
      throw std::system_error(errno, std::generic_category(), "the relay's line");
    }
  }

  void take_response() {
    const ssize_t count = ::read(line_, response_.data() + received_, response_.size() - received_);
    received_ += count > 0 ? static_cast<std::size_t>(count) : 0;
    if (received_ < 3 || received_ < std::size_t{5} + response_[2] || waiting_.empty()) {
      return;
    }
    const auto& adu = waiting_.front().adu;
    const auto body = static_cast<std::uint8_t>(received_ - 2);
    std::array<std::uint8_t, 300> answer{adu[0], adu[1], 0, 0, 0, body};
    std::copy_n(response_.begin(), body, answer.begin() + 6);
    const Moment end = Clock::now();
    if (::write(waiting_.front().client, answer.data(), std::size_t{6} + body) < 0) {
      ::close(waiting_.front().client);
    }
    received_ = 0;
    waiting_.pop_front();
    if (plant_.paced()) {
      sleep_until(end + plant_.t3_5());
    }
    if (!waiting_.empty()) {
      transmit();
    }
  }

  Plant plant_;
  int line_;
  int listening_;
  int epoll_;
  std::deque<Request> waiting_;
  std::array<std::uint8_t, 512> response_{};
  std::size_t received_ = 0;
};

}  // namespace

void run_master(const Plant& plant, const std::vector<std::string>& paths) {
  std::vector<std::jthread> lines;
  lines.reserve(paths.size());
  for (const std::string& path : paths) {
    lines.emplace_back([&plant, path] { master_of_line(plant, path); });
  }
}

void run_relay(const Plant& plant, const std::string& path, int listening) {
  Relay(plant, path, listening).run();
}

}  // namespace mbgate::bench
