// SPDX-License-Identifier: Apache-2.0
// A framer that looks for the answer to a request while a script of bytes and times comes in.
#pragma once

#include <optional>
#include <vector>

#include "bus/serial/framer.hpp"
#include "fuzz/fuzz.hpp"

namespace mbgate::fuzz {

class FramerScript {
 public:
  FramerScript(bus::Framing framing, Script script)
      : script_(script),
        is_ascii_(framing == bus::Framing::ascii),
        framer_(settings(framing), kTiming, counters_) {}

  void run() {
    const std::uint8_t address = script_.byte();
    const auto pdu = modbus::Pdu::from(script_.piece());
    const auto request = pdu ? modbus::Request::parse(*pdu)
                             : Result<modbus::Request, modbus::ExceptionCode>(
                                   modbus::ExceptionCode::illegal_function);
    if (!request) {
      return;
    }
    transaction_.emplace(bus::Transaction{address, *request});
    expect();
    while (!script_.empty()) {
      step();
      check_deadline();
    }
    require(counters_.stray_bytes + counters_.noise_bytes <= received_, "no byte is counted twice");
  }

 private:
  static bus::BusSettings settings(bus::Framing framing) {
    bus::BusSettings settings;
    settings.line.framing = framing;
    return settings;
  }
  static inline const modbus::RtuTiming kTiming{modbus::Baud{19200}, {}};

  void expect() {
    framer_.expect(*transaction_, bus::Instant::min());
    begin(true);
  }
  void listen() {
    framer_.listen();
    begin(false);
  }
  void begin(bool asked) {
    asked_ = asked;
    asked_at_ = now_;
    heard_.clear();
    require(!framer_.in_progress(), "nothing has begun yet");
    take_strays();
  }
  void step() {
    switch (script_.byte() % 6) {
      case 0:
      case 1: receive(script_.piece()); return;
      case 2: wait(std::chrono::microseconds(100) * script_.word()); return;
      case 3: receive_frame(); return;
      case 4: listen(); return;
      default: expect();
    }
  }
  void receive(modbus::Bytes bytes) {
    if (bytes.empty()) {
      return;
    }
    received_ += bytes.size();
    heard_.insert(heard_.end(), bytes.begin(), bytes.end());
    judge(framer_.add(bytes, now_));
  }
  /// A whole frame, in one piece or two.
  void receive_frame() {
    const std::uint8_t address = script_.flag() ? transaction_->address : script_.byte();
    const std::size_t split = script_.byte();
    const auto pdu = modbus::Pdu::from(script_.piece());
    if (!pdu) {
      return;
    }
    const auto frame = framer_.encode(address, *pdu);
    const modbus::Bytes bytes(frame.data(), frame.size());
    const std::size_t first = std::min(split, bytes.size());
    receive(bytes.first(first));
    receive(bytes.subspan(first));
  }
  void wait(bus::Duration duration) {
    now_ += duration;
    judge(framer_.handle_deadline(now_));
  }
  void judge(bus::Verdict verdict) {
    take_strays();
    for (; verdict == bus::Verdict::response; verdict = framer_.again(now_)) {
      check_response();
      const std::uint8_t next = script_.byte() % 4;
      if (next < 2) {
        next == 0 ? expect() : listen();
        return;
      }
    }
    if (verdict == bus::Verdict::damaged) {
      require(asked_, "a frame that nobody asked for is not damaged");
      expect();
    }
  }
  void check_response() {
    require(asked_, "nothing answers what was not asked");
    const auto& response = framer_.response();
    const auto fit = modbus::check_response(transaction_->request, response.bytes());
    require(fit == modbus::ResponseFit::normal || fit == modbus::ResponseFit::exception,
            "a response fits its request");
    require(was_heard(framer_.encode(transaction_->address, response)),
            "a response came from the line, with its unit and checksum");
    require(framer_.found().began >= asked_at_ && framer_.found().began <= now_,
            "a response began after its request");
  }
  void take_strays() {
    std::size_t strays = 0;
    while (framer_.take_unsolicited()) {
      require(++strays <= bus::kMostUnsolicited, "strays are bounded");
    }
  }
  /// CR or LF alone may end a frame of ASCII.
  [[nodiscard]] bool was_heard(bus::FrameBytes frame) const {
    if (is_ascii_) {
      frame.pop_back();
      if (is_in_heard(frame)) {
        return true;
      }
      frame.back() = '\n';
    }
    return is_in_heard(frame);
  }
  /// Hexadecimal characters may be small.
  [[nodiscard]] bool is_in_heard(const bus::FrameBytes& frame) const {
    const auto same = [](std::uint8_t heard, std::uint8_t sent) {
      return heard == sent || (sent >= 'A' && sent <= 'F' && heard == sent + ('a' - 'A'));
    };
    return std::search(heard_.begin(), heard_.end(), frame.begin(), frame.end(), same) !=
           heard_.end();
  }
  /// Time alone comes to an end with every frame.
  void check_deadline() {
    auto deadline = framer_.next_deadline();
    for (int turns = 0; deadline && *deadline <= now_; ++turns) {
      require(turns < 4, "a deadline that was handled is over");
      judge(framer_.handle_deadline(now_));
      deadline = framer_.next_deadline();
    }
    require(!framer_.in_progress() || deadline, "what has begun has an end");
  }

  Script script_;
  bool is_ascii_;
  bus::BusCounters counters_;
  bus::Framer framer_;
  std::optional<bus::Transaction> transaction_;
  std::vector<std::uint8_t> heard_;  // since the request
  std::size_t received_ = 0;
  bool asked_ = false;
  bus::Instant asked_at_;
  bus::Instant now_{std::chrono::seconds(10)};
};

}  // namespace mbgate::fuzz
