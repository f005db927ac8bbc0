// SPDX-License-Identifier: Apache-2.0
// What few devices do: they answer before they boot, or say something of another length first.
#include "soak/serial_wire.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;
using modbus::Pdu;

namespace {
constexpr unsigned kDamagedParting = 350;  // permille
}  // namespace

bool SerialWire::happens_rarely(unsigned permille, const char* kind) {
  const bool happens = permille > 0 && rare_random_.chance(permille);
  if (happens) {
    around_.report.fault(kind);
  }
  return happens;
}

// At once: then it is gone.
void SerialWire::part(const SoakDevice& device, const Flight& flight, const Pdu& pdu) {
  const std::uint8_t address = device.settings().address;
  const Instant begin =
      std::max(around_.schedule.now(), flight.end) + rare_random_.duration(300us, 5ms);
  auto& busy = talks_until_[address];
  if (busy + silence_ > begin) {
    return;
  }
  Frame frame = encode(address, pdu);
  busy = begin + timing_.of(frame.size());
  const bool is_damaged = happens_rarely(kDamagedParting, "damaged_parting");
  if (is_damaged) {
    lose_check(frame);
  }
  say(std::move(frame), begin, Chunks::fine,
      {is_damaged ? std::nullopt : std::optional(address), 1, 0, !is_damaged, flight.number});
}

// Before CR LF in ASCII: a digit of the LRC becomes another one.
void SerialWire::lose_check(Frame& frame) const {
  std::uint8_t& check = frame[frame.size() - (ascii_ ? 3 : 1)];
  check = ascii_ ? (check == '0' ? '1' : '0') : static_cast<std::uint8_t>(check ^ 0x40U);
}

// In ASCII: of the same unit and function, and its LRC is wrong.
std::size_t SerialWire::begin_with_other_length(Frame& frame, const Flight& flight,
                                                const Pdu& pdu) {
  const auto fields = spec::fields_of(flight.pdu);
  if (!ascii_ || pdu.is_exception() || !fields || (!fields->reads && !fields->writes) ||
      !happens_rarely(rates_.other_length, "other_length")) {
    return 0;
  }
  constexpr std::size_t kMostWords = 8;
  spec::Octets bytes(pdu.bytes().begin(), pdu.bytes().end());
  if (fields->reads) {
    bytes.resize(2);
  }
  const std::size_t size = bytes.size() + 2 * rare_random_.between<std::size_t>(1, kMostWords);
  bytes.resize(size == pdu.size() ? size + 2 : size);
  if (fields->reads) {
    bytes[1] = static_cast<std::uint8_t>(bytes.size() - 2);
  }
  Frame damaged = spec::ascii_frame(flight.address, bytes);
  lose_check(damaged);
  frame.insert(frame.begin(), damaged.begin(), damaged.end());
  return damaged.size();
}

// A drive that is late pauses within its answer until it has heard the next request, or for nearly
// as long as ASCII allows. What it was asked for meanwhile it answers behind it.
bool SerialWire::straddles(const Flight& flight, const Frame& whole, Instant begin) {
  const bool may_be = ascii_ && !around_.plan.echoes[bus_] && !around_.plan.beyond &&
                      settings_.line.echo != true &&
                      around_.plan.adapters[bus_] == AdapterKind::uart && flight.expects_answer &&
                      !flight.is_stop && !opaque_;
  if (!may_be || !happens_rarely(rates_.straddles, "straddles")) {
    return false;
  }
  Frame frame = whole;
  if (rare_random_.chance(500)) {
    constexpr std::uint8_t kFailure = 0x04;
    around_.oracle.excepted(flight, kFailure);
    frame =
        encode(flight.address, Pdu::exception(flight.pdu.front(), modbus::ExceptionCode{kFailure}));
  }
  around_.schedule.at(begin, [this, epoch = epoch_, number = flight.number,
                              address = flight.address, frame = std::move(frame)] {
    if (epoch == epoch_ && !is_busy() && !is_hung()) {
      begin_to_straddle(number, address, frame);
    }
  });
  return true;
}

void SerialWire::begin_to_straddle(std::uint64_t flight, std::uint8_t address, const Frame& frame) {
  constexpr Duration kPause = 900ms;
  const Instant now = around_.schedule.now();
  const auto size = rare_random_.between<std::size_t>(1, frame.size() - 3);
  const auto border = frame.begin() + static_cast<std::ptrdiff_t>(size);
  say({frame.begin(), border}, now, Chunks::fine, {std::nullopt, 1, 0, false, flight});
  straddling_ = {ids_, flight, address, size, now, now + timing_.of(size), {border, frame.end()}};
  end_straddling(straddling_->rests_from + kPause);
}

// Whatever else is heard within it, it is no frame any more.
void SerialWire::meet_straddling(const Flight& flight) {
  if (!straddling_) {
    return;
  }
  if (around_.schedule.now() < straddling_->rests_from || flight.address != straddling_->address) {
    straddling_.reset();
    return;
  }
  const Instant begin = flight.end + rare_random_.duration(100us, silence_);
  talks_until_[flight.address] = begin + timing_.of(straddling_->rest.size());
  straddling_->meets = true;
  end_straddling(begin);
}

void SerialWire::end_straddling(Instant at) {
  around_.schedule.at(at, [this, head = straddling_->head] {
    if (!straddling_ || straddling_->head != head || is_hung()) {
      return;
    }
    if (straddling_->meets) {
      around_.report.fault("straddled");
    }
    Straddling it = *std::exchange(straddling_, std::nullopt);
    Content content{it.address, 1, 0, true, it.flight};
    content.began = it.began;
    content.before = it.size;
    say(std::move(it.rest), around_.schedule.now(), Chunks::fine, content);
  });
}

}  // namespace mbgate::soak
