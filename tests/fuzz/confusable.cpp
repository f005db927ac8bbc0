// SPDX-License-Identifier: Apache-2.0
// A bus with requests whose answers could be mistaken for one another, on a driver that keeps its
// promise, but late: every client gets the answer to its own request, or none.
#include "fuzz/confusable_oracle.hpp"

namespace mbgate::fuzz::confusable {
namespace {

class Confusable {
 public:
  Confusable(Script script, Lateness lateness)
      : script_(script),
        lateness_(lateness),
        scene_(script_),
        requests_(requests_of(script_, now_)),
        wire_(scene_, lateness_),
        oracle_(scene_, requests_),
        bus_(scene_.settings, scene_.devices) {}

  void run() {
    bus_.start();
    bus_.handle_opened(now_, scene_.kind);
    work();
    int turns = 0;
    while (step()) {
      require(++turns < kMostTurns, "every request comes to an end");
    }
    for (const Request& request : requests_) {
      require(request.endings == 1, "every request ends");
    }
  }

 private:
  static constexpr int kMostTurns = 20'000;

  /// What happens next: a client asks, the driver reads, or it is time for something.
  bool step() {
    const auto asks = next_ < requests_.size() ? std::optional(requests_[next_].at) : std::nullopt;
    const auto reads = wire_.next_reading();
    plan_deadline();
    const auto next = bus::earlier(bus::earlier(asks, reads), deadline_);
    if (!next || (!asks && open_ == 0)) {
      return false;
    }
    now_ = std::max(now_, *next);
    if (asks == next) {
      submit(requests_[next_++]);
    } else if (reads == next) {
      read();
    } else {
      read();
      deadline_.reset();
      bus_.handle_deadline(now_);
      work();
    }
    return true;
  }
  void plan_deadline() {
    const auto wake = bus_.next_wake();
    if (!wake) {
      wake_at_.reset();
      deadline_.reset();
    } else if (wake_at_ != wake->at || !deadline_) {
      wake_at_ = wake->at;
      deadline_ = std::max(now_, wake->at) + lateness_.next();
    }
  }
  void submit(Request& request) {
    request.job.source = bus::FairnessKey{request.client};
    request.job.deadline = now_ + request.patience;
    request.at = now_;
    for (const Asked& part : request.parts) {
      const auto pdu = modbus::Pdu::from(part.pdu);
      request.job.transactions.push_back({request.device, *modbus::Request::parse(*pdu)});
    }
    seen_.emplace_back();
    ++open_;
    require(bus_.submit(request.job, now_), "there is room for so few");
    work();
  }
  void read() {
    if (hand_in()) {
      work();
    }
  }
  bool hand_in() {
    std::vector<Transmission*> came;
    const Pdu bytes = wire_.read(now_, came);
    if (bytes.empty()) {
      return false;
    }
    std::ranges::for_each(came, [&](Transmission* it) { it->came_at = now_; });
    bus_.handle_bytes(bytes, now_);
    return true;
  }
  void work() {
    for (;;) {
      note_answers();
      const auto action = bus_.poll();
      if (!action) {
        return;
      }
      if (std::holds_alternative<bus::LookAtLine>(*action)) {
        hand_in();
        note_answers();
        bus_.handle_looked(now_);
      } else if (const auto* transmit = std::get_if<bus::TransmitFrame>(&*action)) {
        wire_.send(oracle_.note_sent(transmit->frame, now_), script_);
      } else if (const auto* ended = std::get_if<bus::JobEnded>(&*action)) {
        end(*ended);
      }
    }
  }
  /// Those that were not there before.
  void note_answers() {
    for (std::size_t at = 0; at < seen_.size(); ++at) {
      const Request& request = requests_[at];
      for (std::size_t part = 0; part < request.parts.size(); ++part) {
        const auto& response = request.job.transactions[part].response;
        if (response && !seen_[at].at(part)) {
          seen_[at].at(part) = true;
          oracle_.note_answered(request, part, response->bytes());
        }
      }
    }
  }
  void end(const bus::JobEnded& ended) {
    const auto request =
        std::ranges::find_if(requests_, [&](const Request& it) { return &it.job == ended.job; });
    ++request->endings;
    --open_;
    Oracle::check_ending(*request, ended.ending);
  }

  Instant now_{};
  Script script_;
  Lateness lateness_;
  Scene scene_;
  std::deque<Request> requests_;
  std::size_t next_ = 0;  // request that comes
  std::size_t open_ = 0;
  std::deque<std::array<bool, 2>> seen_;  // answers, of those that came
  Wire wire_;
  Oracle oracle_;
  bus::Bus bus_;
  std::optional<Instant> wake_at_;
  std::optional<Instant> deadline_;  // when the driver comes for it
};

}  // namespace

MBGATE_FUZZ_TARGET(confusable) {
  confusable::Confusable(Script(data, size), confusable::Lateness(data, size)).run();
  return 0;
}

}  // namespace mbgate::fuzz::confusable
