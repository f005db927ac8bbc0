// SPDX-License-Identifier: Apache-2.0
#include "soak/far_server.hpp"

#include <algorithm>

#include "soak/misfits.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;
using modbus::Pdu;

namespace {

constexpr Duration kLatestShut = 3s;                   // that the process may be, and more
constexpr std::uint64_t kBreakChance = 0x42524541ULL;  // apart from the plant's

}  // namespace

FarServer::FarServer(std::size_t bus, Surroundings& around)
    : bus_(bus),
      around_(around),
      rates_(around.plan.rates[bus]),
      break_random_(around.plan.seed ^ (kBreakChance + bus)) {
  for (SoakDevice& device : around.devices) {
    if (static_cast<std::size_t>(device.settings().bus) == bus) {
      devices_.push_back(&device);
    }
  }
}

void FarServer::reset(bool /*is_open*/) {
  ++epoch_;
  stream_.clear();
  ends_.clear();
  in_bout_ = 0;
}

void FarServer::begin_connection() {
  answered_ = unsure_ = false;
  last_byte_ = around_.schedule.now();
  swallows_ = happens(rates_.swallows, "swallow");
  if (!swallows_ && happens(rates_.closes_at_once, "close_at_once")) {
    close_soon("closed_at_once");
  }
  watch_idle();
}

void FarServer::close(const char* kind) {
  if (may_close()) {
    around_.report.fault(kind);
    around_.hang_up(bus_, answered_);
  }
}

void FarServer::close_soon(const char* kind) {
  around_.schedule.after(around_.random.duration(0us, 3ms), [this, epoch = epoch_, kind] {
    if (epoch == epoch_) {
      close(kind);
    }
  });
}

void FarServer::watch_idle() {
  const Duration limit = rates_.idle_close;
  if (limit == Duration{0} || swallows_) {
    return;
  }
  const Instant until = last_byte_ + limit;
  if (around_.schedule.now() >= until) {
    close("idle_close");
    return;
  }
  around_.schedule.after(until - around_.schedule.now(), [this, epoch = epoch_] {
    if (epoch == epoch_) {
      watch_idle();
    }
  });
}

bool FarServer::happens(unsigned permille, const char* kind) {
  if (permille == 0 || !around_.random.chance(permille)) {
    return false;
  }
  around_.report.fault(kind);
  return true;
}

void FarServer::transmit(const Flight& flight) {
  last_byte_ = around_.schedule.now();
  around_.schedule.after(around_.random.duration(50us, 1ms),
                         [this, epoch = epoch_, number = flight.number] {
                           if (epoch == epoch_) {
                             heard(number);
                           }
                         });
}

void FarServer::heard(std::uint64_t number) {
  Flight* flight = around_.oracle.flight(number);
  if (flight == nullptr || flight->pdu.empty() || swallows_ || drops()) {
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
  } else if (flight->expects_answer && flight->is_stop &&
             break_random_.chance(rates_.refuses_stop)) {
    around_.report.fault("stop_refused");
    const auto at = break_random_.below(kStopRefusals.size());
    pdu = Pdu::exception(request.function(), modbus::ExceptionCode{kStopRefusals.at(at)});
  } else {
    const SoakDevice::Outcome outcome = device.carry_out(request, now);
    pdu = outcome.answer;
    around_.oracle.executed(*flight);
    if (outcome.parting && break_random_.chance(rates_.boots_answered)) {
      part(*flight, *outcome.parting);
    }
  }
  if (pdu && pdu->is_exception()) {
    around_.oracle.excepted(*flight, pdu->bytes()[1]);
  }
  if (!pdu || happens(rates_.never, "never")) {
    return;
  }
  const Duration limit = flight->deadline - flight->end;
  Duration wait = around_.random.duration(100us, limit / 2);
  if (in_bout_ > 0) {
    wait = limit + break_random_.duration(2ms, 100ms);
  } else if (happens(rates_.late, "late")) {
    wait = around_.random.duration(limit, 5 * limit);
  }
  Answer answer{number, flight->identifier, flight->address, {}};
  answer.pdu.assign(pdu->bytes().begin(), pdu->bytes().end());
  answer.fits = pdu->is_exception() || !make_misfit(answer.pdu, rates_, around_.random,
                                                    [this](unsigned permille, const char* kind) {
                                                      return happens(permille, kind);
                                                    });
  around_.schedule.after(wait, [this, epoch = epoch_, answer] {
    if (epoch == epoch_) {
      say(answer);
    }
  });
}

// Of so many requests nothing is done; for a while what follows is answered late.
bool FarServer::drops() {
  constexpr unsigned kLate = 30;
  if (rates_.overload == 0) {
    return false;
  }
  in_bout_ = in_bout_ == rates_.overload + kLate ? 1 : in_bout_ + 1;
  const bool drops = in_bout_ <= rates_.overload;
  around_.report.fault(drops ? "overloaded" : "overloaded_late");
  return drops;
}

// At once: then its device is gone.
void FarServer::part(const Flight& flight, const Pdu& pdu) {
  around_.report.fault("boots_answered");
  const Answer answer{
      flight.number, flight.identifier, flight.address, {pdu.bytes().begin(), pdu.bytes().end()}};
  around_.schedule.after(break_random_.duration(100us, 3ms), [this, epoch = epoch_, answer] {
    if (epoch == epoch_) {
      say(answer);
    }
  });
}

void FarServer::say(const Answer& answer) {
  const bool is_other = happens(rates_.other_unit, "other_unit");
  const auto shown = static_cast<std::uint8_t>(is_other ? answer.unit ^ 0xFFU : answer.unit);
  const auto append = [&](std::uint16_t with) {
    const auto adu = spec::tcp_adu(with, shown, answer.pdu);
    stream_.insert(stream_.end(), adu.begin(), adu.end());
  };
  if (happens(rates_.unknown_identifier, "unknown_identifier")) {
    append(static_cast<std::uint16_t>(answer.identifier + 0x4000U));
  }
  append(answer.identifier);
  if (answer.fits && (!is_other || !around_.plan.settings.buses[bus_].check_unit)) {
    ends_.emplace_back(stream_.size(), answer.number);
    if (is_other) {
      around_.oracle.misnamed(bus_, answer.number);
    }
  } else {
    unsure_ = true;  // late, it is a sign of life as others are
  }
  if (happens(rates_.twice, "twice")) {
    append(answer.identifier);
  }
  if (breaks_off()) {
    return;
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

// The connection is closed behind the first bytes of an answer.
bool FarServer::breaks_off() {
  if (!may_close() || !break_random_.chance(rates_.breaks_off)) {
    return false;
  }
  const std::size_t last = ends_.empty() ? stream_.size() : ends_.front().first;
  const std::uint64_t epoch = epoch_;
  flush(break_random_.between<std::size_t>(1, last - 1));
  if (epoch == epoch_) {
    close("broken_off");
  }
  return true;
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
  bool closes = false;
  while (!ends_.empty() && ends_.front().first == 0) {
    note_answer(ends_.front().second);
    ends_.pop_front();
    closes = closes || happens(rates_.closes_after, "close_after_answer");
  }
  last_byte_ = around_.schedule.now();
  around_.oracle.bytes_came(bus_, {});
  const std::uint64_t epoch = epoch_;
  around_.deliver(bus_, piece);
  if (closes && epoch == epoch_) {
    close_soon("closed_after_answer");
  } else if (epoch == epoch_ && stream_.empty() &&
             happens(rates_.breaks_framing, "broken_framing")) {
    break_framing();
  }
}

// A length that no MBAP header has, or an RTU frame. After that it says nothing.
void FarServer::break_framing() {
  reset(true);
  swallows_ = true;
  around_.framing_lost(bus_);
  around_.deliver(
      bus_, around_.random.one_of<std::vector<std::uint8_t>>({{0, 1, 0, 0, 0, 1, 1, 3},
                                                              {0, 1, 0, 0, 0xFF, 0xFF, 1, 3},
                                                              {1, 3, 2, 0, 7, 0xF9, 0x86, 0}}));
  around_.schedule.after(kLatestShut, [this, epoch = epoch_] {
    if (epoch == epoch_) {
      around_.oracle.violation("not_shut", "a connection whose framing is lost");
    }
  });
}

void FarServer::note_answer(std::uint64_t number) {
  const Flight* flight = around_.oracle.flight(number);
  const bool in_time = flight != nullptr && around_.schedule.now() < flight->deadline;
  answered_ = answered_ || in_time;
  unsure_ = unsure_ || !in_time;
  around_.oracle.tcp_answer_came(number);
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
