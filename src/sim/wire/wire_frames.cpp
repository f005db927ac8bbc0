// SPDX-License-Identifier: Apache-2.0
// What the devices hear: the gateway's transmissions as frames, and the devices' answers to them.
#include <algorithm>
#include <utility>

#include "sim/wire/wire.hpp"

namespace mbgate::sim {
namespace {

FrameOnWire join_to_frame(const std::vector<TransmissionOnWire*>& parts) {
  FrameOnWire frame{.begin = parts.front()->begin, .end = parts.back()->end, .intact = true};
  for (TransmissionOnWire* part : parts) {
    frame.bytes.insert(frame.bytes.end(), part->bytes.begin(), part->bytes.end());
    frame.intact = frame.intact && part->understood;
    part->framed = true;
  }
  return frame;
}

}  // namespace

void Wire::close_frames(Instant at) {
  std::vector<FrameOnWire> closed;
  std::vector<Transmission*> parts;
  for (Transmission& transmission : on_wire_) {
    if (!transmission.from_gateway || transmission.framed) {
      continue;
    }
    parts.push_back(&transmission);
    if (transmission.continued) {
      continue;
    }
    if (transmission.end + silence_ <= at) {
      closed.push_back(join_to_frame(parts));
    }
    parts.clear();
  }
  for (FrameOnWire& frame : closed) {
    hand_to_devices(std::move(frame));
  }
}

// A frame may come in several transmissions, and one transmission may carry several frames.
void Wire::close_ascii_frames(Instant at) {
  std::vector<FrameOnWire> closed;
  for (Transmission& transmission : on_wire_) {
    if (!transmission.from_gateway || transmission.framed || transmission.end > at) {
      continue;
    }
    transmission.framed = true;
    for (std::size_t i = 0; i < transmission.bytes.size(); ++i) {
      const Instant begin = transmission.begin + time_of(i, true);
      if (auto frame = ascii_.feed(transmission.bytes[i], begin, begin + time_of(1, true))) {
        closed.push_back({.begin = frame->begin,
                          .end = frame->end,
                          .bytes = frame->bytes,
                          .intact = transmission.understood});
      }
    }
  }
  for (FrameOnWire& frame : closed) {
    hand_to_devices(std::move(frame));
  }
}

void Wire::hand_to_devices(FrameOnWire frame) {
  frame.intact = frame.intact && decode_frame(settings_.framing, frame.bytes).has_value();
  ++counters_.frames;
  if (frame.intact) {
    let_answer(frame);
  } else {
    ++counters_.bad_crc;
  }
  frames_.push_back(std::move(frame));
  while (frames_.size() > settings_.frames_kept) {
    frames_.pop_front();
  }
}

void Wire::let_answer(FrameOnWire& frame) {
  for (Device& device : devices_) {
    const std::uint64_t before = device.heard();
    const auto answer = device.receive(frame.bytes, frame.end);
    if (device.heard() != before) {
      frame.heard_by.push_back(device.settings().address);
    }
    if (answer) {
      ++counters_.answers;
      const Duration wait =
          answer->counts_from_end ? std::max(silence_, answer->after) : silence_ + answer->after;
      put_on_wire({.begin = frame.end + wait,
                   .end = frame.end + wait + time_of(answer->frame.size(), false),
                   .bytes = {answer->frame.begin(), answer->frame.end()},
                   .from_gateway = false});
    }
  }
}

}  // namespace mbgate::sim
