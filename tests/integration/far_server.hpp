// SPDX-License-Identifier: Apache-2.0
// A Modbus TCP server by libmodbus, on a thread of its own: the far end of a bus with mode = "tcp".
// Some of its registers behave badly.
#pragma once

#include <modbus.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace mbgate::test {

/// What the server has received, in this order.
struct Arrival {
  unsigned transaction = 0;
  unsigned unit = 0;
  unsigned function = 0;
  unsigned address = 0;
};

class FarServer {
 public:
  /// Register n holds 1000 + n until it is written.
  static constexpr int kRegisters = 300;
  static constexpr int kSilentRegister = 280;   ///< is never answered
  static constexpr int kLateRegister = 281;     ///< is answered in front of the next answer
  static constexpr int kVendorRegister = 282;   ///< is answered with exception 11 (hexadecimal)
  static constexpr int kPathRegister = 283;     ///< is answered with exception 0A
  static constexpr int kClosingRegister = 284;  ///< is answered, and the connection closed then
  /// Is answered every second time; the connection is closed instead of the other answers.
  static constexpr int kCuttingRegister = 285;

  /// On loopback; port 0 lets the kernel choose.
  explicit FarServer(std::uint16_t port = 0);
  ~FarServer();
  FarServer(const FarServer&) = delete;
  FarServer& operator=(const FarServer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Answers only when so many requests are there, or no more came for so long; the last one first.
  void gather(std::size_t count, int limit_ms) {
    gather_limit_ms_ = limit_ms;
    gather_ = count;
  }
  /// Closes a connection after each answer.
  void close_after_answers() { closes_after_answers_ = true; }
  /// Closes what it accepts.
  void close_at_once(bool closes) { closes_at_once_ = closes; }
  /// Answers as this unit, whatever the request says.
  void answer_as(std::uint8_t unit) { unit_ = unit; }
  /// Connections that it has accepted.
  [[nodiscard]] std::size_t connections() const { return accepted_; }
  [[nodiscard]] std::vector<Arrival> arrivals();
  /// The most requests that were waiting for their answers at a time.
  [[nodiscard]] std::size_t most_waiting() const { return most_waiting_; }
  /// Was a write ever waiting together with another request?
  [[nodiscard]] bool had_company() const { return had_company_; }

 private:
  struct Query {
    int socket;
    std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> bytes;
    int size;
  };
  struct Free {
    void operator()(modbus_t* context) const { modbus_free(context); }
    void operator()(modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }
  };

  void serve();
  bool serve_once();
  void accept_one();
  void take_query(int socket);
  void hang_up(int socket);
  void answer_all();
  void answer(const Query& query);
  void send_exception(const Query& query, std::uint8_t code) const;

  int listening_ = -1;
  int stop_[2] = {-1, -1};  ///< closing the second end stops the thread
  std::uint16_t port_ = 0;
  std::unique_ptr<modbus_t, Free> context_;
  std::unique_ptr<modbus_mapping_t, Free> mapping_;
  std::vector<int> connections_;
  std::vector<Query> waiting_;
  std::optional<Query> late_;
  std::atomic<std::size_t> gather_{1};
  std::atomic<int> gather_limit_ms_{-1};
  std::atomic<bool> closes_after_answers_{false};
  std::atomic<bool> closes_at_once_{false};
  std::atomic<int> unit_{-1};  ///< none: as the request
  std::atomic<std::size_t> accepted_{0};
  bool cuts_ = false;
  std::atomic<std::size_t> most_waiting_{0};
  std::atomic<bool> had_company_{false};
  std::mutex mutex_;
  std::vector<Arrival> arrivals_;
  std::thread thread_;
};

}  // namespace mbgate::test
