// SPDX-License-Identifier: Apache-2.0
// What devices hear and how their answers go wrong.
#include "soak/serial_wire.hpp"

#include <algorithm>
#include <span>

#include "soak/misfits.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;
using modbus::Pdu;

namespace {
constexpr std::uint64_t kEchoChance = 0x57495245ULL;  // apart from the plant's
constexpr std::uint64_t kRareOnWire = 0x52415245574952ULL;
constexpr std::uint64_t kSlowOnWire = 0x534C4F574E455353ULL;
constexpr std::uint8_t kNobodyFrom = 60;
constexpr std::uint8_t kNobodyTo = 240;
constexpr unsigned kRefusesLate = 300;  // permille of writes that are answered late
}  // namespace

SerialWire::SerialWire(std::size_t bus, Surroundings& around)
    : bus_(bus),
      around_(around),
      settings_(around.plan.settings.buses[bus]),
      rates_(around.plan.rates[bus]),
      line_(settings_.line),
      timing_(settings_.line),
      silence_(spec::silence_of(settings_)),
      ascii_(settings_.line.framing == bus::Framing::ascii),
      adapter_(around.plan.adapters[bus], around.schedule, around.random,
               [this](const Heard& heard) { hand_over(heard); }),
      echo_random_(around.plan.seed ^ (kEchoChance + bus)),
      rare_random_(around.plan.seed ^ (kRareOnWire + bus)),
      slow_random_(around.plan.seed ^ (kSlowOnWire + bus)) {
  for (SoakDevice& device : around.devices) {
    if (static_cast<std::size_t>(device.settings().bus) == bus) {
      devices_.push_back(&device);
    }
  }
}

// Drives that are set to another line have nothing to say any more.
void SerialWire::reset(bool is_open) {
  const Instant now = around_.schedule.now();
  const bus::LineSettings& line = settings_.line;
  if (!spec::is_same_line(line, line_)) {
    ++epoch_;
    messages_.clear();
    talks_until_.clear();
    works_until_.clear();
    asked_until_.clear();
    line_ = line;
    timing_ = spec::WireTimes(line);
    ascii_ = line.framing == bus::Framing::ascii;
  }
  silence_ = spec::silence_of(settings_);
  is_open_ = is_open;
  adapter_.reset();
  for (auto& [id, message] : messages_) {
    message.lost = message.heard;
  }
  sending_ = own_end_ > now ? 0 : sending_;
  own_end_ = std::min(own_end_, now);
  overheard_.forget();
  echo_.reset();
  straddling_.reset();
  echo_shown_ = false;
  if (is_open) {
    deaf_until_ = is_hung() && goes_on_hanging() ? Instant::max() : Instant::min();
  }
}

bool SerialWire::happens(unsigned permille, const char* kind) {
  if (permille == 0 || !around_.random.chance(permille)) {
    return false;
  }
  around_.report.fault(kind);
  return true;
}

SerialWire::Frame SerialWire::encode(std::uint8_t address, const Pdu& pdu) const {
  return ascii_ ? spec::ascii_frame(address, pdu.bytes()) : spec::rtu_frame(address, pdu.bytes());
}

SoakDevice* SerialWire::device_at(std::uint8_t address) {
  const auto found = std::ranges::find(devices_, address,
                                       [](const SoakDevice* it) { return it->settings().address; });
  return found == devices_.end() ? nullptr : *found;
}

void SerialWire::transmit(const Flight& flight, Bytes frame) {
  own_damaged_ = false;
  meet_straddling(flight);
  opaque_ = !flight.pdu.empty() && spec::is_opaque(flight.pdu);
  own_end_ = flight.end;
  sending_ = flight.number;
  asked_ = flight.address;
  if (flight.expects_answer) {
    asked_until_[flight.address] = flight.due;
  }
  for (auto& [id, message] : messages_) {
    if (message.begin <= around_.schedule.now() && message.end > around_.schedule.now()) {
      own_damaged_ = true;
      garble(message);
      around_.report.fault("collision");
    }
  }
  own_damaged_ = own_damaged_ || is_babbling();
  const auto prompt = prompt_end(flight);
  is_prompt_ = prompt.has_value();
  begin_echo(flight, {frame.begin(), frame.end()});
  around_.schedule.at(prompt.value_or(flight.end), [this, epoch = epoch_, number = flight.number] {
    if (epoch == epoch_) {
      heard(number);
    }
  });
}

void SerialWire::heard(std::uint64_t number) {
  Flight* flight = around_.oracle.flight(number);
  if (number != sending_ || own_damaged_ || (is_hung() && swallows_) || flight == nullptr ||
      flight->pdu.empty() || happens(rates_.request_damaged, "request_damaged")) {
    return;
  }
  const auto request = Pdu::from(flight->pdu);
  if (flight->is_broadcast) {
    carry_out_all(*flight);
    around_.oracle.executed(*flight);
    return;
  }
  SoakDevice* device = device_at(flight->address);
  if (device == nullptr) {
    return;
  }
  if (device->is_dead(around_.schedule.now())) {
    around_.report.fault("dead");
    return;
  }
  if (!waits_its_turn(*device, *flight)) {
    answer(*device, *flight, *request);
  }
}

void SerialWire::answer(SoakDevice& device, const Flight& flight, const Pdu& request) {
  Random& random = around_.random;
  const drive::DeviceTiming& timing = flight.timing;
  const Instant now = around_.schedule.now();
  std::optional<Pdu> pdu;
  bool slow = false;
  if (flight.expects_answer && !flight.is_stop && happens(rates_.exception, "exception")) {
    const auto code = random.one_of<std::uint8_t>({0x04, 0x05, 0x07, 0x11, 0x12});
    pdu = Pdu::exception(request.function(), modbus::ExceptionCode{code});
    around_.oracle.excepted(flight, code);
  } else if (const auto code = refusal_of(flight)) {
    pdu = Pdu::exception(request.function(), modbus::ExceptionCode{*code});
    around_.oracle.excepted(flight, *code);
  } else {
    const SoakDevice::Outcome outcome = device.carry_out(request, now);
    pdu = outcome.answer;
    slow = outcome.slow;
    if (outcome.parting && happens_rarely(rates_.boots_answered, "boots_answered")) {
      part(device, flight, *outcome.parting);
    }
    around_.oracle.executed(flight);
    if (pdu && pdu->is_exception()) {
      around_.oracle.excepted(flight, pdu->bytes()[1]);
    }
  }
  if (!pdu || happens(rates_.never, "never")) {
    return;
  }
  const bool is_quick = rates_.are_quick || ways_of(device).service > Duration{0};
  const Duration longest = is_quick ? 700us : timing.response_timeout / 2;
  Duration wait = timing.response_wait + 300us + random.duration(0us, longest);
  if (slow) {
    wait += random.duration(0us, timing.response_timeout);
    wait = std::min<Duration>(wait, (flight.deadline - flight.end) / 2);
  }
  if (timing.response_wait > Duration{0} && happens(rates_.early, "early")) {
    wait = 300us;
  }
  if (is_prompt_ && !slow) {
    wait = echo_random_.duration(0us, 2ms);
  }
  answer_with_fault(device, flight, *pdu, now + wait);
}

void SerialWire::answer_with_fault(SoakDevice& device, const Flight& flight, const Pdu& pdu,
                                   Instant begin) {
  const std::uint8_t address = device.settings().address;
  Frame frame = encode(address, pdu);
  auto& busy = talks_until_[address];
  begin = std::max(begin, busy + silence_);
  if (happens(rates_.late, "late")) {
    const bool may_refuse = flight.is_write && !flight.is_stop && flight.expects_answer;
    if (may_refuse && !pdu.is_exception() && happens_to_echo(kRefusesLate, "late_exception")) {
      constexpr std::uint8_t kFailure = 0x04;
      around_.oracle.excepted(flight, kFailure);
      frame = encode(address, Pdu::exception(pdu.function(), modbus::ExceptionCode{kFailure}));
    }
    answer_late(device, flight, frame, begin);
    return;
  }
  if (gets_stuck(flight, frame, begin)) {
    return;
  }
  const bool excess = happens(rates_.twice, "twice");
  if (excess) {
    frame.insert(frame.end(), frame.begin(), frame.end());
  } else if (happens(rates_.babble, "babble")) {
    const std::size_t size = frame.size();
    append_excess(frame);
    const std::size_t behind = frame.size() - size;
    say(std::move(frame), begin, Chunks::fine, {address, 1, behind, true, flight.number});
    return;
  } else if (const Spoilt spoilt = spoil(frame, pdu, address); spoilt != Spoilt::no) {
    const bool is_frame = spoilt == Spoilt::misfit;
    say(std::move(frame), begin, Chunks::fine,
        {is_frame ? std::optional(address) : std::nullopt, 1, 0, false, flight.number});
    return;
  }
  const bool may_glitch = !excess && (ascii_ || (!opaque_ && !pdu.is_exception()));
  const bool glitches = may_glitch && happens(rates_.glitch, "glitch");
  const std::size_t lead = glitches ? begin_with_glitch(frame, flight.pdu)
                           : excess ? 0
                                    : begin_with_other_length(frame, flight, pdu);
  const bool paused = !excess && happens(rates_.pieces, "pieces");
  if (!excess && lead == 0) {
    answer_again(device, flight, frame, begin);
  }
  const Duration slack = spec::slack_of(settings_);
  busy = begin + timing_.of(frame.size()) + (paused ? slack : Duration{0});
  say(std::move(frame), begin,
      excess   ? Chunks::fine
      : paused ? Chunks::paused
               : Chunks::usual,
      {address, excess ? 2U : 1U, 0, true, flight.number, lead});
}

// Makes something else of the answer.
SerialWire::Spoilt SerialWire::spoil(Frame& frame, const Pdu& pdu, std::uint8_t address) {
  Random& random = around_.random;
  if (happens(rates_.garbage, "garbage")) {
    frame.assign(random.between(1U, 40U), 0);
    for (auto& byte : frame) {
      byte = static_cast<std::uint8_t>(random.below(256));
    }
    return Spoilt::unreadable;
  }
  if (happens(rates_.wrong_unit, "wrong_unit")) {
    frame =
        encode(static_cast<std::uint8_t>(random.between<unsigned>(kNobodyFrom, kNobodyTo)), pdu);
    return Spoilt::unreadable;
  }
  if (happens(rates_.wrong_function, "wrong_function")) {
    std::vector<std::uint8_t> bytes(pdu.bytes().begin(), pdu.bytes().end());
    bytes[0] = mistaken(bytes[0]);
    frame = encode(address, *Pdu::from(bytes));
    return Spoilt::misfit;
  }
  if (happens(rates_.bad_crc, "bad_crc")) {
    lose_check(frame);
    return Spoilt::unreadable;
  }
  if (happens(rates_.damaged, "damaged")) {
    const bool breaks_off = !ascii_ && echo_random_.chance(150);
    breaks_off ? frame.resize(echo_random_.between<std::size_t>(1, 3)) : damage(frame);
    lose_crc(frame, 0);
    return Spoilt::unreadable;
  }
  if (!pdu.is_exception() && pdu.function() <= 4 && pdu.size() < 240 &&
      happens(rates_.too_long, "too_long")) {
    std::vector<std::uint8_t> bytes(pdu.bytes().begin(), pdu.bytes().end());
    bytes.insert(bytes.end(), {0xAA, 0xBB});
    bytes[1] = static_cast<std::uint8_t>(bytes[1] + 2);
    frame = encode(address, *Pdu::from(bytes));
    return Spoilt::misfit;
  }
  std::vector<std::uint8_t> bytes(pdu.bytes().begin(), pdu.bytes().end());
  if (make_misfit(bytes, rates_, echo_random_, [this](unsigned permille, const char* kind) {
        return happens_to_echo(permille, kind);
      })) {
    frame = encode(address, *Pdu::from(bytes));
    return Spoilt::misfit;
  }
  return Spoilt::no;
}

}  // namespace mbgate::soak
