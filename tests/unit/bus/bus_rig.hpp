// SPDX-License-Identifier: Apache-2.0
// A Bus in virtual time at 19200 8E1: a character takes 572.9 us, t3.5 is 2.005 ms, 8
// characters 4.583 ms.
#pragma once

#include <gmock/gmock.h>

#include <deque>
#include <functional>

#include "bus/bus.hpp"
#include "support/hex.hpp"

namespace mbgate::test {

using namespace std::chrono_literals;
using bus::Duration;
using bus::Ending;
using bus::Instant;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

inline constexpr auto kRead = "03 0000 0001";
inline constexpr auto kReadFrame = "01 03 00 00 00 01 84 0A";
inline constexpr auto kAnswer = "01 03 02 12 34 B5 33";
inline constexpr auto kOther = "03 0010 0001";  // the same shape as kRead
inline constexpr auto kOtherFrame = "01 03 00 10 00 01 85 CF";
inline constexpr auto kOtherDevice = "02 03 00 00 00 01 84 39";  // kRead there
inline constexpr auto kT35 = 2005209ns;                          // 38.5 bits, rounded up
inline constexpr auto kEmission = 4583334ns;                     // 88 bits, rounded up

class Bus : public testing::Test {
 protected:
  void open(const bus::BusSettings& settings) { open(settings, usual_devices(settings)); }
  void open(const bus::BusSettings& settings, const std::vector<drive::Device>& devices) {
    bus_.emplace(settings, devices);
    bus_->start();
    bus_->handle_opened(now_);
    drain();
    advance(5ms);
  }
  /// Addresses 1 to 32. An address that no device has goes offline sooner.
  static std::vector<drive::Device> usual_devices(const bus::BusSettings& settings) {
    constexpr std::uint8_t kLast = 32;
    std::vector<drive::Device> devices;
    for (std::uint8_t address = 1; address <= kLast; ++address) {
      devices.push_back({"device-" + std::to_string(address), {}, address, settings.timing});
    }
    return devices;
  }
  /// Reads are sent twice.
  void open_retrying() {
    auto retrying = settings();
    retrying.timing.retries = 1;
    open(retrying);
  }
  void update(const bus::BusSettings& settings, const std::vector<drive::Device>& devices) {
    bus_->update(settings, devices, now_);
    drain();
  }
  static bus::BusSettings settings() {
    bus::BusSettings settings;
    settings.line.echo = false;
    settings.listen_first = 0ms;
    settings.timing.response_timeout = 100ms;
    settings.timing.retries = 0;
    settings.timing.offline_after = 0;
    settings.coalesce = false;
    return settings;
  }
  bus::Job& job(std::string_view request, std::uint8_t address = 1) {
    bus::Job& job = jobs_.emplace_back();
    job.deadline = now_ + 60s;
    add(job, request, address);
    return job;
  }
  static void add(bus::Job& job, std::string_view request, std::uint8_t address = 1) {
    const auto pdu = modbus::Pdu::from(unhex(request));
    job.transactions.push_back({address, *modbus::Request::parse(*pdu)});
    if (address == modbus::kBroadcastAddress) {
      job.transactions.back().broadcast = drive::BroadcastForm{};
    }
  }
  /// The same, of another client address.
  bus::Job& job_of(std::uint32_t source, std::string_view request, std::uint8_t address = 1) {
    bus::Job& made = job(request, address);
    made.source = bus::FairnessKey{source};
    return made;
  }
  void submit(bus::Job& job) {
    EXPECT_TRUE(bus_->submit(job, now_));
    drain();
  }
  void line(std::string_view bytes) {
    bus_->handle_bytes(unhex(bytes), now_);
    drain();
  }
  void advance(Duration duration) {
    const Instant end = now_ + duration;
    for (auto at = next_deadline(); at && *at <= end; at = next_deadline()) {
      now_ = std::max(now_, *at);
      bus_->handle_deadline(now_);
      drain();
    }
    now_ = end;
  }
  [[nodiscard]] std::optional<Instant> next_deadline() const {
    const auto wake = bus_ ? bus_->next_wake() : std::nullopt;
    return wake ? std::optional(wake->at) : std::nullopt;
  }
  void drain() {
    while (const auto action = bus_->poll()) {
      if (std::holds_alternative<bus::LookAtLine>(*action)) {
        if (!unread_.empty()) {
          bus_->handle_bytes(unhex(std::exchange(unread_, {})), now_);
        }
        bus_->handle_looked(now_);
      } else if (const auto* transmit = std::get_if<bus::TransmitFrame>(&*action)) {
        frames_.push_back(hex({transmit->frame.data(), transmit->frame.size()}));
        frame_times_.push_back(now_);
      } else if (const auto* ended = std::get_if<bus::JobEnded>(&*action)) {
        endings_.push_back(ended->ending);
        ended_.push_back(*ended);
        ended_at_.push_back(now_);
      } else if (std::holds_alternative<bus::OpenLine>(*action)) {
        ++opens_;
      } else if (std::holds_alternative<bus::CloseLine>(*action)) {
        if (bus_->link().serves()) {
          replaced_.push_back(std::exchange(is_news_, false));
        } else {
          ++closes_;
        }
      } else if (const auto* news = std::get_if<bus::LineNotice>(&*action)) {
        is_news_ = news->fault == bus::LineFault::unanswered;
        if (!is_news_) {
          faults_.push_back(news->fault);
        }
      } else if (const auto* notice = std::get_if<bus::DeviceNotice>(&*action)) {
        notices_.push_back(notice->kind);
        last_notice_ = *notice;
      } else if (std::holds_alternative<bus::NeverSilent>(*action)) {
        ++never_silent_;
      } else if (const auto* quality = std::get_if<bus::QualityNotice>(&*action)) {
        qualities_.push_back(*quality);
      }
    }
  }
  /// A request that was just transmitted gets no answer; the response timeout is 100 ms.
  void time_out() { advance(kEmission + 100ms); }
  /// From the last transmission on until the next one.
  Duration until_next_frame(Duration limit = 2s) {
    const std::size_t before = frames_.size();
    const Instant start = now_;
    advance(limit);
    return frames_.size() > before ? frame_times_[before] - start : Duration::max();
  }

  /// The devices that requests go to within `limit`. `answer` plays each, and says its address.
  std::vector<int> served(Duration limit, const std::function<int()>& answer) {
    std::vector<int> devices;
    const Instant end = now_ + limit;
    while (now_ < end) {
      const std::size_t before = frames_.size();
      advance(1ms);
      if (frames_.size() > before) {
        devices.push_back(answer());
      }
    }
    return devices;
  }
  /// The device refuses the function that it was asked for, which is an answer too.
  void refuse(std::uint8_t address, std::uint8_t function = 3) {
    const std::vector<std::uint8_t> pdu{static_cast<std::uint8_t>(function | modbus::kExceptionBit),
                                        2};
    const auto frame = modbus::encode_rtu(address, *modbus::Pdu::from(pdu));
    bus_->handle_bytes({frame.data(), frame.size()}, now_);
    drain();
  }

  Instant now_{};
  std::string unread_;  ///< lies in the line's descriptor, and is read when the bus wants to look
  std::deque<bus::Job> jobs_;
  std::optional<bus::Bus> bus_;
  std::vector<std::string> frames_;
  std::vector<Instant> frame_times_;
  std::vector<Ending> endings_;
  std::vector<Instant> ended_at_;
  std::vector<bus::JobEnded> ended_;
  unsigned opens_ = 0;
  unsigned closes_ = 0;
  unsigned never_silent_ = 0;
  bool is_news_ = false;        // that nothing comes
  std::vector<bool> replaced_;  // whether it was news
  std::vector<bus::DeviceNotice::Kind> notices_;
  std::vector<bus::LineFault> faults_;
  bus::DeviceNotice last_notice_{};
  std::vector<bus::QualityNotice> qualities_;
};

}  // namespace mbgate::test
