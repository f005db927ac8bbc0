// SPDX-License-Identifier: Apache-2.0
// What must hold in `confusable`: whose answer each client gets, and what is sent how often.
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
    const Duration quarantine =
        scene_.timing().quarantine.value_or(scene_.timing().response_timeout);
    const Transmission sent{number, &request, request.job.current, now, end, due, due + quarantine};
    check_times(sent);
    return sent_.emplace_back(sent);
  }
  /// A client's request, or a part of it, has its answer.
  void note_answered(const Request& request, std::size_t part, modbus::Bytes response) {
    const auto number = number_in(response);
    const auto answers = std::ranges::find_if(sent_, [&](const Transmission& it) {
      return (!number || it.number == *number) && is_answer(it, request, part, response);
    });
    require(answers != sent_.end(), "an answer is given only to whom the device has answered");
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
};

}  // namespace mbgate::fuzz::confusable
