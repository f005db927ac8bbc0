// SPDX-License-Identifier: Apache-2.0
// Clients that ask a drive one request after the other, in virtual time, and judge each answer. The
// drive works in order and as slowly as it is told, and may answer twice. The value of a register
// is its address, so that an answer to another request is seen.
#pragma once

#include <map>
#include <random>

#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {

class Plant : public Bus {
 protected:
  struct Drive {
    Duration service = 5ms;       ///< for each request, one after the other
    double jitter = 0.1;          ///< of that
    double lost = 0;              ///< the share of answers that are lost
    double doubled = 0;           ///< the share of answers that come twice
    Duration second_after = 9ms;  ///< the second one, behind the first
    double second_jitter = 0.1;   ///< of that
  };
  struct Score {
    unsigned right = 0;
    unsigned wrong = 0;
    unsigned failed = 0;
    Instant last_wrong{};
  };

  void run(Duration time) {
    const Instant end = now_ + time;
    while (now_ < end) {
      ask_again();
      auto next = next_deadline().value_or(end);
      if (!answers_.empty()) {
        next = std::min(next, answers_.begin()->first);
      }
      now_ = std::clamp(next, now_, end);
      while (!answers_.empty() && answers_.begin()->first <= now_) {
        const auto frame = answers_.begin()->second;
        answers_.erase(answers_.begin());
        bus_->handle_bytes({frame.data(), frame.size()}, now_);
        drain();
        take_frames();
      }
      if (const auto due = next_deadline(); due && *due <= now_) {
        bus_->handle_deadline(now_);
        drain();
        take_frames();
      }
      judge();
    }
  }

  /// Each asks its requests in turn.
  void add_client(std::vector<std::string> requests) {
    clients_.push_back({std::move(requests), 0, nullptr});
  }

  Drive drive_;
  Score score_;
  std::mt19937 random_{1};  // NOLINT(cert-msc51-cpp): the same each time

 private:
  struct Asking {
    std::vector<std::string> requests;
    std::size_t next;
    bus::Job* job;
  };

  double chance() { return std::uniform_real_distribution(0.0, 1.0)(random_); }
  Duration around(Duration duration, double jitter) {
    const double factor = 1 - jitter + 2 * jitter * chance();
    return std::chrono::duration_cast<Duration>(duration * factor);
  }

  void ask_again() {
    for (Asking& client : clients_) {
      if (client.job == nullptr) {
        const auto source = static_cast<std::uint32_t>(&client - clients_.data());
        client.job =
            &job_of(source, with_value(client.requests[client.next++ % client.requests.size()]));
        submit(*client.job);
        take_frames();
      }
    }
  }
  /// Each write has another value.
  std::string with_value(std::string request) {
    if (const auto at = request.find("VVVV"); at != std::string::npos) {
      request.replace(
          at, 4,
          hex(std::vector<std::uint8_t>{static_cast<std::uint8_t>(++value_ >> 8U & 0xFFU),
                                        static_cast<std::uint8_t>(value_ & 0xFFU)}));
    }
    return request;
  }
  void take_frames() {
    for (std::size_t at = 0; at < frames_.size(); ++at) {
      const auto bytes = unhex(frames_[at]);
      serve(*modbus::Request::parse(modbus::decode_rtu(bytes)->pdu),
            frame_times_[at] + bytes.size() * 573us);
    }
    frames_.clear();
    frame_times_.clear();
  }
  void serve(const modbus::Request& asked, Instant left) {
    free_at_ = std::max(free_at_, left) + around(drive_.service, drive_.jitter);
    const auto bytes = asked.pdu().bytes();
    std::vector<std::uint8_t> answer(
        bytes.begin(), bytes.begin() + std::min<std::ptrdiff_t>(5, std::ssize(bytes)));
    if (asked.is_read()) {
      answer = {bytes[0], 2, bytes[1], bytes[2]};
    } else {
      done_.emplace(free_at_, asked.pdu());
    }
    if (chance() >= drive_.lost) {
      send(answer, free_at_);
    }
    if (chance() < drive_.doubled) {
      send(answer, free_at_ + around(drive_.second_after, drive_.second_jitter));
    }
  }
  void send(const std::vector<std::uint8_t>& pdu, Instant at) {
    const auto frame = modbus::encode_rtu(1, *modbus::Pdu::from(pdu));
    answers_.emplace(at + frame.size() * 573us, frame);
  }
  [[nodiscard]] bool was_done(const modbus::Pdu& write) const {
    return std::ranges::any_of(
        done_, [&](const auto& it) { return it.first <= now_ && it.second == write; });
  }
  [[nodiscard]] bool is_right(const bus::Transaction& transaction) const {
    const modbus::Pdu& asked = transaction.request.pdu();
    if (!transaction.request.is_read()) {
      return was_done(asked);
    }
    const auto answer = transaction.response->bytes();
    return answer[2] == asked.bytes()[1] && answer[3] == asked.bytes()[2];
  }
  void judge() {
    for (const auto& [job, ending] : ended_) {
      if (ending != Ending::answered) {
        ++score_.failed;
      } else if (is_right(job->transactions.front())) {
        ++score_.right;
      } else {
        ++score_.wrong;
        score_.last_wrong = now_;
      }
      std::ranges::find(clients_, job, &Asking::job)->job = nullptr;
    }
    ended_.clear();
    endings_.clear();
    ended_at_.clear();
    while (!jobs_.empty() &&
           std::ranges::find(clients_, &jobs_.front(), &Asking::job) == clients_.end()) {
      jobs_.pop_front();
    }
    std::erase_if(done_, [&](const auto& it) { return it.first < now_ - 60s; });
  }

  std::vector<Asking> clients_;
  std::multimap<Instant, modbus::RtuBytes> answers_;
  std::multimap<Instant, modbus::Pdu> done_;
  unsigned value_ = 0;
  Instant free_at_{};
};

}  // namespace mbgate::test
