// SPDX-License-Identifier: Apache-2.0
// What must hold in `confusable`: whose answer each client gets, what is sent how often, and what
// is not sent while an answer is owed that it could be mistaken for.
#pragma once

#include "fuzz/confusable_wire.hpp"

namespace mbgate::fuzz::confusable {

class Oracle {
 public:
  Oracle(const Scene& scene, const std::deque<Request>& requests)
      : scene_(scene), requests_(requests) {}

  /// A frame leaves now.
  Transmission& note_sent(const bus::FrameBytes& frame, Instant now) {
    const Request& request = sender(frame);
    const Instant end = now + time_of(frame.size());
    const Instant due = end + scene_.timing().response_timeout + scene_.timing().response_wait;
    const auto number = static_cast<std::uint8_t>(sent_.size() + 1);
    const Transmission sent{
        number, &request, request.job.current, now, end, due, due + quarantine_of(request, due)};
    check_times(sent);
    check_debts(sent);
    for (Transmission& it : sent_) {
      it.settled = it.settled || (it.device() == sent.device() && now >= it.until);
    }
    return sent_.emplace_back(sent);
  }
  /// The whole answer was handed in. Of several to the same request nobody can tell which one it
  /// answers: as long as one is missing, it may be that to the last one.
  void note_came(Transmission& answered, Instant now) {
    answered.came_at = now;
    const auto oldest = std::ranges::find_if(sent_, [&](const Transmission& it) {
      return !it.settled && it.is_same(answered) && now < it.until;
    });
    if (oldest != sent_.end()) {
      oldest->settled = true;
    }
  }
  /// The product says that it has learned of longer lateness.
  void note_late(const bus::DeviceNotice& notice, Instant now) {
    Device& device = devices_.at(notice.address);
    device.learned = notice.quarantine;
    device.learned_at = now;
  }
  /// A client's request, or a part of it, has its answer.
  void note_answered(const Request& request, std::size_t part, modbus::Bytes response,
                     Instant now) {
    const auto number = number_in(response);
    const auto answers = std::ranges::find_if(sent_, [&](const Transmission& it) {
      return (!number || it.number == *number) && is_answer(it, request, part, response);
    });
    require(answers != sent_.end(), "an answer is given only to whom the device has answered");
    Device& device = devices_.at(request.device);
    device.answered_at = now;
    device.took.push_back({now, std::max(*answers->came_at - sent_.back().end, Duration{0})});
  }
  static void check_ending(const Request& request, bus::Ending ending) {
    require(request.endings == 1, "a request ends once");
    if (ending != bus::Ending::answered) {
      return;
    }
    const auto& transactions = request.job.transactions;
    const bool refused = std::ranges::any_of(transactions, [](const bus::Transaction& it) {
      return it.response && it.response->is_exception();
    });
    require(refused || std::ranges::all_of(transactions,
                                           [](const auto& it) { return it.response.has_value(); }),
            "what is answered has all its answers");
  }

 private:
  struct Took {
    Instant at;
    Duration time;
  };
  struct Device {
    Duration learned{0};
    Instant learned_at;
    std::optional<Instant> answered_at;  // last, and it was waited for
    std::vector<Took> took;
  };
  static constexpr Duration kRemembered = std::chrono::minutes(1);  // whole, before it shrinks
  static constexpr Duration kAdapterKeeps = std::chrono::milliseconds(20);

  [[nodiscard]] Duration quarantine_of(const Request& request, Instant due) const {
    const Device& device = devices_.at(request.device);
    const Duration usual = scene_.timing().quarantine.value_or(scene_.timing().response_timeout);
    return due < device.learned_at + kRemembered ? std::max(usual, device.learned) : usual;
  }
  [[nodiscard]] const Request& sender(const bus::FrameBytes& frame) const {
    const Request* sender = nullptr;
    for (const Request& request : requests_) {
      if (is_in_flight(request.job)) {
        require(sender == nullptr, "one transaction at a time");
        sender = &request;
      }
    }
    require(sender != nullptr && sender->endings == 0, "what is sent is for somebody");
    const Pdu expected = frame_of(sender->device, sender->parts.at(sender->job.current).pdu);
    require(std::ranges::equal(frame, expected), "what is sent is what was asked");
    return *sender;
  }

  /// How often, and not too late.
  void check_times(const Transmission& sent) const {
    const Request& request = *sent.request;
    const auto before =
        static_cast<unsigned>(std::ranges::count_if(sent_, [&](const Transmission& it) {
          return it.request == &request && it.part == sent.part;
        }));
    const drive::DeviceTiming& timing = scene_.timing();
    if (request.is_stop()) {
      require(before <= timing.stop_retries, "a stop is repeated so often at most");
      return;
    }
    require(before == 0 || is_read(sent.pdu()) || timing.retry_writes,
            "no write is transmitted twice");
    require(before <= timing.retries, "nothing is repeated more often than it may be");
    require(sent.begin < request.at + request.patience, "nothing is sent after its deadline");
  }

  [[nodiscard]] bool repeats_read(const Transmission& sent) const {
    const Request& request = *sent.request;
    return is_read(sent.pdu()) && std::ranges::any_of(sent_, [&](const Transmission& it) {
             const bool shared = scene_.settings.coalesce && it.begin >= request.at;
             return it.is_same(sent) &&
                    ((it.request == &request && it.part == sent.part) || shared);
           });
  }
  void check_debts(const Transmission& sent) const {
    if (sent.request->is_stop() || repeats_read(sent)) {
      return;
    }
    std::optional<Instant> last;
    for (const Transmission& it : sent_) {
      if (it.device() != sent.device() || it.settled || sent.begin >= it.until) {
        continue;
      }
      require(it.function() != sent.function(),
              "nothing of the same function is sent while an answer is owed");
      last = it.begin;
    }
    if (!last) {
      return;
    }
    const Device& device = devices_.at(sent.device());
    require(device.answered_at && *device.answered_at > *last,
            "nothing is sent to a device that has not answered since");
    Duration least = kAdapterKeeps;
    for (const Took& took : device.took) {
      least = sent.begin < took.at + kRemembered ? std::max(least, 4 * took.time) : least;
    }
    require(sent.begin >= *device.answered_at + least, "an owed answer has time to be over");
  }

  /// Was it sent for this request, carried out, and answered so?
  [[nodiscard]] bool is_answer(const Transmission& it, const Request& request, std::size_t part,
                               modbus::Bytes response) const {
    // A zero that a driver leaves behind a frame keeps its CRC right: where silence alone tells the
    // end, it seems to be a part of it.
    const bool opaque = it.function() == 0x41 && response.size() > it.answer.size();
    const modbus::Bytes told = opaque ? response.first(it.answer.size()) : response;
    if (!it.came_at || !std::ranges::equal(it.answer, told) || it.device() != request.device ||
        it.pdu() != request.parts.at(part).pdu) {
      return false;
    }
    if (request.is_stop()) {
      return still_stopped(it);
    }
    const bool shares = scene_.settings.coalesce && request.parts.size() == 1 &&
                        is_read(it.pdu()) && it.begin >= request.at;
    return (it.request == &request && it.part == part) || shares;
  }
  /// A stop waits for nothing that is owed, so that the answer may be that to the same one before:
  /// nothing has been sent since that could have undone it.
  [[nodiscard]] bool still_stopped(const Transmission& stop) const {
    return std::ranges::none_of(sent_, [&](const Transmission& it) {
      return it.number > stop.number && it.device() == stop.device() && !is_read(it.pdu()) &&
             !it.request->parts[it.part].is_stop;
    });
  }

  const Scene& scene_;
  const std::deque<Request>& requests_;
  std::deque<Transmission> sent_;
  std::array<Device, 3> devices_;
};

}  // namespace mbgate::fuzz::confusable
