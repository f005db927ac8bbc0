// SPDX-License-Identifier: Apache-2.0
// How bytes travel over a serial line to the gateway, and who else is on it.
#include <algorithm>
#include <utility>

#include "soak/serial_wire.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;
using modbus::Pdu;

// Adapters hand bytes over in chunks, up to some milliseconds apart. Where something follows that
// the gateway cannot foresee, they must come without a gap that looks like silence.
void SerialWire::say(Frame bytes, Instant begin, Chunks chunks, const Content& content) {
  Random& random = around_.random;
  const std::uint64_t id = ++ids_;
  const Duration character = timing_.of(1);
  Duration paused{0};
  const Duration most_paused =
      std::min<Duration>(content.most_paused, ascii_ ? 1s : spec::slack_of(settings_) - 3ms);
  const Duration step = chunks == Chunks::fine || chunks == Chunks::torn
                            ? std::max(silence_ / 3, character)
                            : random.duration(500us, 4ms);
  const auto most = std::max<std::size_t>(1, static_cast<std::size_t>(step / character));
  Instant last = begin;
  std::vector<std::pair<Instant, std::size_t>> deliveries;
  for (std::size_t at = 0; at < bytes.size();) {
    at = std::min(bytes.size(), at + most);
    const bool may_pause =
        chunks == Chunks::paused || (chunks == Chunks::torn && at < content.lead);
    if (may_pause && at < bytes.size()) {
      const Duration pause = random.duration(1ms, 8ms) * (ascii_ ? 1 : random.one_of({1, 1, 25}));
      paused = std::min(paused + pause, most_paused);
    }
    last = begin + timing_.of(at) + paused;
    const Instant due = last + (chunks == Chunks::usual ? random.duration(0us, 300us) : 0us);
    deliveries.emplace_back(deliveries.empty() ? due : std::max(due, deliveries.back().first), at);
  }
  const std::size_t frame = (bytes.size() - content.excess - content.lead) / content.copies;
  const std::size_t good_to = content.address ? bytes.size() - content.excess : 0;
  messages_.emplace(id, Message{std::move(bytes), begin, last, character, content, frame, good_to});
  around_.schedule.at(begin, [this, epoch = epoch_, id] {
    if (epoch == epoch_) {
      begin_message(id);
    }
  });
  for (const auto& [at, until] : deliveries) {
    around_.schedule.at(at, [this, epoch = epoch_, id, until = until] {
      if (epoch == epoch_) {
        hear(id, until);
      }
    });
  }
}

void SerialWire::begin_message(std::uint64_t id) {
  const Instant now = around_.schedule.now();
  Message& message = messages_.at(id);
  if (straddling_ && straddling_->head != id) {
    straddling_.reset();
  }
  std::optional<std::uint8_t> lost;
  bool collides = (own_end_ > now && !is_prompt_) || is_babbling();
  own_damaged_ = own_damaged_ || (own_end_ > now && !is_prompt_);
  for (auto& [other_id, other] : messages_) {
    if (other_id != id && other.begin <= now && other.end > now) {
      collides = true;
      lost = garble(other);
    }
  }
  if (collides) {
    garble(message);
    around_.report.fault("collision");
  }
  if (message.bytes.front() == lost) {
    message.bytes.front() ^= 1U;
  }
}

// From now on nobody can read it. Returns the byte that is lost first: it must not come from
// elsewhere by chance.
std::optional<std::uint8_t> SerialWire::garble(Message& message) {
  const Duration past = around_.schedule.now() - message.begin;
  const auto from =
      static_cast<std::size_t>(std::max<Duration>(past, Duration{0}) / message.character);
  const std::size_t good = std::max(from, message.heard);
  if (ascii_ && good + 1 >= message.bytes.size()) {
    return std::nullopt;  // CR alone ends a frame
  }
  message.content.copies =
      std::min(message.content.copies, message.ended(good) - message.ended(message.heard));
  const auto lost = good < message.bytes.size() ? std::optional(message.bytes[good]) : std::nullopt;
  for (std::size_t at = good; at < message.bytes.size(); ++at) {
    // What cannot stand in a frame, or another byte than it was: by chance nothing stays whole.
    message.bytes[at] = static_cast<std::uint8_t>(
        ascii_ ? message.bytes[at] | 0x80U : message.bytes[at] ^ around_.random.between(1U, 255U));
  }
  lose_crc(message.bytes, good);
  message.good_to = std::min(message.good_to, good);
  return lost;
}

void SerialWire::damage(Frame& frame) {
  Random& random = around_.random;
  const std::size_t size = frame.size() - (ascii_ ? 2 : 0);  // half of an end is one
  const auto place = static_cast<std::ptrdiff_t>(random.below(size));
  switch (random.between(0U, 2U)) {
    case 0:
      for (unsigned bits = ascii_ ? 1 : random.between(1U, 3U); bits > 0; --bits) {
        // Each in a byte of its own: the same bit twice would be no damage; nor would a digit of
        // the other case.
        auto& byte = frame[(static_cast<std::size_t>(place) + bits) % size];
        byte =
            static_cast<std::uint8_t>(byte ^ (1U << (ascii_ ? random.below(5) : random.below(8))));
      }
      return;
    case 1:  // not the ':', which what was heard before it may have in its place
      frame.erase(frame.begin() + (ascii_ && place == 0 ? 1 : place));
      return;
    default: {
      const Frame whole = frame;
      frame.insert(frame.begin() + 1 + place / 2, frame[static_cast<std::size_t>(1 + place / 2)]);
      // Beside bytes that are alike, the frame itself is still whole.
      if (std::ranges::equal(whole, std::span(frame).first(whole.size())) ||
          std::ranges::equal(whole, std::span(frame).last(whole.size()))) {
        frame[whole.size() / 2] ^= 0x40U;
      }
      return;
    }
  }
}

// Damage that leaves a good CRC, once in 65,536 times, could be seen by nobody.
void SerialWire::lose_crc(std::vector<std::uint8_t>& damaged, std::size_t from) const {
  for (std::size_t size = from + 1; !ascii_ && size <= damaged.size(); ++size) {
    if (spec::ends_in_its_crc(Bytes(damaged).first(size))) {
      damaged[size - 1] ^= 1U;
    }
  }
}

void SerialWire::hear(std::uint64_t id, std::size_t until) {
  Message& message = messages_.at(id);
  overhear(message, until);
  Heard heard;
  heard.bytes.assign(message.bytes.begin() + static_cast<std::ptrdiff_t>(message.heard),
                     message.bytes.begin() + static_cast<std::ptrdiff_t>(until));
  const Instant arrival = adapter_.arrival();
  const std::size_t lead = message.content.lead;
  heard.strange_request = message.lost == 0 && message.heard < lead && until >= lead;
  if (message.heard <= lead || (message.heard - lead) % message.frame == 0) {
    message.frame_began = arrival;
  }
  const std::size_t frames =
      std::min(message.content.copies, message.ended(until) - message.ended(message.heard));
  message.content.copies -= frames;
  const Content& content = message.content;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    if (content.address && lead + message.copies_heard * message.frame >= message.cut_to()) {
      const bool is_nobodys = content.flight == 0 || content.is_second || message.copies_heard > 0;
      heard.frames.push_back({*content.address, content.fits, is_nobodys, content.flight,
                              content.began.value_or(message.frame_began)});
      heard.frames.back().size = message.frame + content.before;
      heard.frames.back().lead = lead;
      heard.frames.back().is_second = content.is_second;
    }
    ++message.copies_heard;
    message.frame_began = arrival;
  }
  message.heard = until;
  const bool is_heard = is_open_ && message.begin >= deaf_until_;
  if (until == message.bytes.size()) {
    messages_.erase(id);
  }
  if (is_heard) {
    adapter_.take(std::move(heard), arrival);
  }
}

void SerialWire::hand_over(const Heard& heard) {
  around_.oracle.bytes_came(bus_, heard.bytes);
  for (const HeardFrame& frame : heard.frames) {
    around_.oracle.frame_came(bus_, frame);
    if (frame.fits && frame.flight != 0 && frame.began >= own_end_) {
      asked_until_.erase(frame.address);
    }
  }
  if (heard.strange_request) {
    around_.oracle.stranger_asked(bus_);
  }
  if (heard.echo) {
    around_.oracle.echo_came(bus_, *heard.echo);
  }
  around_.deliver(bus_, heard.bytes);
}

namespace {

// Does another's frame begin in one of its first bytes, and end with the frame behind them or in
// it?
bool hides_frame(spec::Bytes bytes, std::size_t lead) {
  for (std::size_t at = 0; at < lead; ++at) {
    if (frame_within(bytes.subspan(at)) || spec::ends_in_its_crc(bytes.subspan(at))) {
      return true;
    }
  }
  return false;
}

}  // namespace

// What a line without bias picks up, or a driver that turns on. In ASCII what may begin a frame
// too.
// Not as many bytes as a request like `asked` has.
std::size_t SerialWire::begin_with_glitch(Frame& frame, const PduBytes& asked) {
  Random& random = around_.random;
  const std::size_t most = ascii_ ? 7 : std::min<std::size_t>(7, asked.size() + 2);
  const std::size_t size = random.between(std::size_t{1}, most);
  for (std::size_t count = size; count > 0; --count) {
    const std::uint8_t byte =
        ascii_ ? random.one_of<std::uint8_t>({':', '0', '1', '3', 'F', '\r', 0x00, 0x7F})
               : random.one_of<std::uint8_t>({0xFE, 0xF8, 0xC0, 0x80, 0x7F, 0x00, 0xFF,
                                              static_cast<std::uint8_t>(random.below(256))});
    frame.insert(frame.begin(), byte);
  }
  // Wherever it stands, one of its bytes becomes another.
  for (std::size_t at = 0; !ascii_ && hides_frame(frame, size); at = (at + 1) % size) {
    ++frame[at];
    around_.report.fault("chance_crc");
  }
  return size;
}

void SerialWire::append_excess(Frame& frame) {
  for (unsigned count = around_.random.between(1U, 100U); count > 0; --count) {
    frame.push_back(static_cast<std::uint8_t>(around_.random.below(256)));
  }
}

bool SerialWire::is_busy() const {
  const Instant now = around_.schedule.now();
  return own_end_ > now || is_babbling() || std::ranges::any_of(messages_, [&](const auto& entry) {
           return entry.second.begin <= now;
         });
}

void SerialWire::later(Duration every, void (SerialWire::*what)()) {
  if (every > Duration{0}) {
    around_.schedule.after(around_.random.duration(every / 4, 2 * every),
                           [this, what] { (this->*what)(); });
  }
}

void SerialWire::begin_trouble() {
  later(rates_.noise_every, &SerialWire::make_noise);
  later(rates_.foreign_every, &SerialWire::ask_as_stranger);
  later(rates_.dead_every, &SerialWire::kill_a_device);
  later(rates_.babbles_every, &SerialWire::begin_babble);
  later(rates_.hangs_every, &SerialWire::begin_hang);
  for (std::size_t place = 0; place < devices_.size(); ++place) {
    put_to_sleep(place);
  }
}

void SerialWire::make_noise() {
  if (rates_.noise_every == Duration{0}) {
    return;
  }
  around_.report.fault("noise");
  Frame noise(around_.random.between(1U, 6U));
  for (auto& byte : noise) {
    byte = around_.random.one_of<std::uint8_t>(
        {0x00, 0xFF, static_cast<std::uint8_t>(around_.random.below(256))});
  }
  if (ascii_) {  // not the beginning that a damaged frame behind it has lost, nor the end
    for (const std::uint8_t border : {std::uint8_t{':'}, std::uint8_t{0x0A}}) {
      std::ranges::replace(noise, border, std::uint8_t{0xFF});
    }
  }
  say(std::move(noise), around_.schedule.now(), Chunks::fine, {});
  later(rates_.noise_every, &SerialWire::make_noise);
}

void SerialWire::kill_a_device() {
  if (rates_.dead_every == Duration{0}) {
    return;
  }
  later(rates_.dead_every, &SerialWire::kill_a_device);
  around_.report.fault("death");
  devices_[around_.random.below(devices_.size())]->die_until(around_.schedule.now() +
                                                             around_.random.duration(50ms, 5s));
}

}  // namespace mbgate::soak
