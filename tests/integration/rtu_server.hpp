// SPDX-License-Identifier: Apache-2.0
// A Modbus RTU server by libmodbus, on a thread of its own: the far end of a serial line.
#pragma once

#include <modbus.h>
#include <pty.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>

namespace mbgate::test {

struct FreeModbus {
  void operator()(modbus_t* context) const { modbus_free(context); }
  void operator()(modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }
};
using Context = std::unique_ptr<modbus_t, FreeModbus>;

// A libmodbus server on the far end of a pty. Register n holds unit * 1000 + n, until it is
// written.
class RtuServer {
 public:
  static constexpr int kRegisters = 300;

  explicit RtuServer(int unit) {
    char name[64];
    if (openpty(&far_, &near_, name, nullptr, nullptr) != 0) {
      throw std::runtime_error("no pty");
    }
    termios raw{};
    tcgetattr(near_, &raw);
    cfmakeraw(&raw);
    tcsetattr(near_, TCSANOW, &raw);
    path_ = name;
    mapping_.reset(modbus_mapping_new(kRegisters, kRegisters, kRegisters, kRegisters));
    std::iota(mapping_->tab_registers, mapping_->tab_registers + kRegisters, unit * 1000);
    std::iota(mapping_->tab_input_registers, mapping_->tab_input_registers + kRegisters,
              unit * 2000);
    for (int bit = 0; bit < kRegisters; ++bit) {
      mapping_->tab_input_bits[bit] = bit % 3 == 0 ? 1 : 0;
    }
    context_.reset(modbus_new_rtu(name, 115200, 'N', 8, 1));
    modbus_set_slave(context_.get(), unit);
    modbus_set_socket(context_.get(), far_);
    modbus_set_indication_timeout(context_.get(), 0, 50'000);
    thread_ = std::thread([this] { serve(); });
  }
  ~RtuServer() {
    stop_ = true;
    thread_.join();
    close(far_);
    close(near_);
  }
  RtuServer(const RtuServer&) = delete;
  RtuServer& operator=(const RtuServer&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  void serve() {
    std::uint8_t query[MODBUS_RTU_MAX_ADU_LENGTH];
    while (!stop_) {
      const int size = modbus_receive(context_.get(), query);
      if (size > 0) {
        modbus_reply(context_.get(), query, size, mapping_.get());
      }
    }
  }

  int far_ = -1;
  int near_ = -1;
  std::string path_;
  std::unique_ptr<modbus_mapping_t, FreeModbus> mapping_;
  Context context_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace mbgate::test
