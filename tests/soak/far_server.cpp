// SPDX-License-Identifier: Apache-2.0
#include "soak/far_server.hpp"

#include <algorithm>

#include "modbus/mbap.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;
using modbus::Pdu;

FarServer::FarServer(std::size_t bus, Surroundings& around)
    : bus_(bus), around_(around), rates_(around.plan.rates[bus]) {
  for (SoakDevice& device : around.devices) {
    if (static_cast<std::size_t>(device.settings().bus) == bus) {
      devices_.push_back(&device);
    }
  }
}

void FarServer::reset() {
  ++epoch_;
  stream_.clear();
  ends_.clear();
}

bool FarServer::happens(unsigned permille, const char* kind) {
  if (permille == 0 || !around_.random.chance(permille)) {
    return false;
  }
  around_.report.fault(kind);
  return true;
}

void FarServer::transmit(const Flight& flight) {
  around_.schedule.after(around_.random.duration(50us, 1ms),
                         [this, epoch = epoch_, number = flight.number] {
                           if (epoch == epoch_) {
                             heard(number);
                           }
                         });
}

void FarServer::heard(std::uint64_t number) {
  Flight* flight = around_.oracle.flight(number);
  if (flight == nullptr || flight->pdu.empty()) {
    return;
  }
  const auto found = std::ranges::find(devices_, flight->address,
                                       [](const SoakDevice* it) { return it->settings().address; });
  const Instant now = around_.schedule.now();
  if (found == devices_.end() || (*found)->is_dead(now)) {
    around_.report.fault("dead");
    return;
  }
  SoakDevice& device = **found;
  const Pdu request = *Pdu::from(flight->pdu);
  std::optional<Pdu> pdu;
  if (flight->expects_answer && !flight->is_stop && happens(rates_.exception, "exception")) {
    pdu = Pdu::exception(request.function(), modbus::ExceptionCode{0x11});
  } else {
    pdu = device.carry_out(request, now).answer;
    around_.oracle.executed(*flight);
  }
  if (pdu && pdu->is_exception()) {
    around_.oracle.excepted(*flight, pdu->bytes()[1]);
  }
  if (!pdu || happens(rates_.never, "never")) {
    return;
  }
  const Duration limit = flight->deadline - flight->end;
  Duration wait = around_.random.duration(100us, limit / 2);
  if (happens(rates_.late, "late")) {
    wait = around_.random.duration(limit, 5 * limit);
  }
  around_.schedule.after(wait, [this, epoch = epoch_, number, identifier = flight->identifier,
                                unit = flight->address, pdu] {
    if (epoch == epoch_) {
      answer(number, identifier, unit, *pdu);
    }
  });
}

void FarServer::answer(std::uint64_t number, std::uint16_t identifier, std::uint8_t unit,
                       const Pdu& pdu) {
  const auto append = [&](std::uint16_t with) {
    const auto adu = modbus::encode(modbus::MbapAdu{{with, unit}, pdu});
    stream_.insert(stream_.end(), adu.begin(), adu.end());
  };
  if (happens(rates_.unknown_identifier, "unknown_identifier")) {
    append(static_cast<std::uint16_t>(identifier + 0x4000U));
  }
  append(identifier);
  ends_.emplace_back(stream_.size(), number);
  if (happens(rates_.twice, "twice")) {
    append(identifier);
  }
  const std::size_t first =
      happens(rates_.pieces, "pieces") ? 1 + around_.random.below(stream_.size()) : stream_.size();
  flush(first);
  if (!stream_.empty()) {
    around_.schedule.after(around_.random.duration(10us, 2ms), [this, epoch = epoch_] {
      if (epoch == epoch_) {
        flush(stream_.size());
      }
    });
  }
}

void FarServer::flush(std::size_t bytes) {
  if (bytes == 0) {
    return;
  }
  const std::vector<std::uint8_t> piece(stream_.begin(),
                                        stream_.begin() + static_cast<std::ptrdiff_t>(bytes));
  stream_.erase(stream_.begin(), stream_.begin() + static_cast<std::ptrdiff_t>(bytes));
  for (auto& [end, number] : ends_) {
    end -= std::min(end, bytes);
  }
  while (!ends_.empty() && ends_.front().first == 0) {
    around_.oracle.tcp_answer_came(ends_.front().second);
    ends_.pop_front();
  }
  around_.oracle.bytes_came(bus_);
  around_.deliver(bus_, piece);
}

void FarServer::begin_trouble() {
  if (rates_.dead_every > Duration{0}) {
    around_.schedule.after(around_.random.duration(rates_.dead_every / 4, 2 * rates_.dead_every),
                           [this] { kill_a_device(); });
  }
}

void FarServer::kill_a_device() {
  if (rates_.dead_every == Duration{0}) {
    return;
  }
  around_.report.fault("death");
  devices_[around_.random.below(devices_.size())]->die_until(around_.schedule.now() +
                                                             around_.random.duration(50ms, 5s));
  begin_trouble();
}

}  // namespace mbgate::soak
