// SPDX-License-Identifier: Apache-2.0
// An adapter that hears what it sends, and a line on which somebody never stops talking.
#include <algorithm>
#include <utility>

#include "soak/serial_wire.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {
constexpr unsigned kMostLostInRow = 3;
}  // namespace

// A UART hears each byte when it has left; what only looks like one has all of it at once. An echo
// that is cut begins late, or ends early: the receiver was switched.
void SerialWire::begin_echo(const Flight& flight, const Frame& frame) {
  echo_.reset();
  if (!around_.plan.echoes[bus_]) {
    return;
  }
  // Many that are lost in a row would show that there is none.
  if (is_hung() ||
      (echoes_lost_ < kMostLostInRow && happens_to_echo(rates_.echo_lost, "echo_lost")) ||
      (echoes_lost_ < kMostLostInRow && echo_shown_ &&
       happens_rarely(rates_.echo_flickers, "echo_flickers"))) {
    ++echoes_lost_;
    around_.oracle.echo_lost(flight);
    return;
  }
  echoes_lost_ = 0;
  OwnEcho& echo = echo_.emplace(OwnEcho{flight.number, frame});
  if (happens_to_echo(rates_.echo_cut, "echo_cut")) {
    const auto left = static_cast<std::ptrdiff_t>(echo_random_.between(
        std::size_t{1}, std::max<std::size_t>(echo.bytes.size(), 4) - (ascii_ ? 3 : 1)));
    echo_random_.chance(500) ? echo.bytes.erase(echo.bytes.begin(), echo.bytes.begin() + left)
                             : echo.bytes.erase(echo.bytes.begin() + left, echo.bytes.end());
    echo.is_whole = false;
  } else if (happens_to_echo(rates_.echo_damaged, "echo_damaged")) {
    echo.bytes[echo_random_.below(echo.bytes.size())] ^= 0x10U;
    spoil_echo(flight);
  } else if (settings_.line.echo == false) {
    if (const auto size = frame_within(echo.bytes)) {
      around_.report.fault("chance_crc");
      echo.bytes[*size - 1] ^= 0x10U;
      spoil_echo(flight);
    }
  }
  const std::size_t size = echo.bytes.size();
  const auto at = [&](Instant instant, std::size_t until) {
    around_.schedule.at(instant, [this, epoch = epoch_, number = flight.number, until] {
      if (epoch == epoch_) {
        hear_echo(number, until);
      }
    });
  };
  if (around_.plan.kinds[bus_] != bus::LineKind::uart || is_prompt_) {
    at(flight.begin + echo_random_.duration(0us, (flight.end - flight.begin) / 4), size);
    return;
  }
  const Duration step = echo_random_.duration(500us, 4ms);
  const std::size_t most = std::max<std::size_t>(1, static_cast<std::size_t>(step / timing_.of(1)));
  for (std::size_t until = std::min(most, size); until < size; until += most) {
    at(flight.begin + timing_.of(until), until);
  }
  at(flight.end, size);
}

void SerialWire::spoil_echo(const Flight& flight) {
  echo_->is_whole = false;
  if (!std::exchange(echo_->is_spoilt, true)) {
    around_.oracle.echo_spoilt(flight);
  }
}

void SerialWire::hear_echo(std::uint64_t number, std::size_t until) {
  if (!echo_ || echo_->flight != number) {
    return;
  }
  OwnEcho& echo = *echo_;
  Heard heard;
  heard.bytes.assign(echo.bytes.begin() + static_cast<std::ptrdiff_t>(echo.heard),
                     echo.bytes.begin() + static_cast<std::ptrdiff_t>(until));
  if (own_damaged_ && !echo.is_spoilt) {
    heard.bytes[echo_random_.below(heard.bytes.size())] ^= 0x10U;
    if (const Flight* flight = around_.oracle.flight(number)) {
      spoil_echo(*flight);
    }
  }
  overhear(heard.bytes, echo.is_spoilt);
  const Instant arrival = adapter_.arrival();
  const bool in_one = echo.heard == 0;
  echo.began = in_one ? arrival : echo.began;
  echo.heard = until;
  if (until == echo.bytes.size()) {
    if (settings_.line.echo != false && echo.is_whole) {
      overheard_.forget();  // it can be told
    }
    heard.echo = HeardEcho{number, until, echo.is_whole, echo.began, in_one};
    const Flight* flight = around_.oracle.flight(number);
    echo_shown_ |= echo.is_whole && flight != nullptr && !looks_like_answer(*flight);
    echo_.reset();
  }
  adapter_.take(std::move(heard), arrival);
}

bool SerialWire::happens_to_echo(unsigned permille, const char* kind) {
  const bool happens = permille > 0 && echo_random_.chance(permille);
  if (happens) {
    around_.report.fault(kind);
  }
  return happens;
}

// Some device answers before the request has left, as far as the gateway can work out.
std::optional<Instant> SerialWire::prompt_end(const Flight& flight) {
  if (flight.is_broadcast || !happens_to_echo(rates_.prompt, "prompt")) {
    return std::nullopt;
  }
  const Duration length = flight.end - flight.begin;
  return flight.begin + echo_random_.duration(length / 3, length);
}

void SerialWire::begin_babble() {
  if (rates_.babbles_every == Duration{0}) {
    return;
  }
  later(rates_.babbles_every, &SerialWire::begin_babble);
  const bool is_on_its_way = std::ranges::any_of(
      messages_, [&](const auto& entry) { return entry.second.end <= around_.schedule.now(); });
  if (!is_babbling() && !is_on_its_way &&
      !is_hung()) {  // nothing overtakes what was on the line before
    around_.report.fault("never_silent");
    babbles_until_ = around_.schedule.now() + echo_random_.duration(2500ms, 7s);
    babble_on(epoch_);
  }
}

bool SerialWire::is_babbling() const { return around_.schedule.now() < babbles_until_; }

// Its bytes complete no frame that it cuts.
void SerialWire::babble_on(std::uint64_t epoch) {
  if (!is_babbling() || epoch != epoch_) {
    return;
  }
  const Instant now = around_.schedule.now();
  straddling_.reset();
  std::optional<std::uint8_t> lost;
  own_damaged_ = own_damaged_ || own_end_ > now;
  for (auto& [id, message] : messages_) {
    if (message.begin <= now && message.end > now) {
      lost = garble(message);
    }
  }
  Heard heard;
  for (unsigned count = echo_random_.between(1U, 4U); count > 0; --count) {
    heard.bytes.push_back(echo_random_.one_of<std::uint8_t>({0xFE, 0xFF}));
  }
  if (heard.bytes.front() == lost) {
    heard.bytes.front() ^= 1U;
  }
  overhear(heard.bytes, true);
  if (is_open_) {
    const Instant arrival = adapter_.arrival();
    adapter_.take(std::move(heard), arrival);
  }
  around_.schedule.after(echo_random_.duration(silence_ / 3, silence_ * 2 / 3),
                         [this, epoch] { babble_on(epoch); });
}

}  // namespace mbgate::soak
