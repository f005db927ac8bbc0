// SPDX-License-Identifier: Apache-2.0
#include "bus/serial/line_silence.hpp"

namespace mbgate::bus {

LineSilence::LineSilence(const BusSettings& settings)
    : timing_(settings.line.baud, settings.line.format),
      frame_gap_(settings.frame_gap.value_or(timing_.t3_5())),
      turnaround_(settings.turnaround),
      settle_(settings.settle) {}

void LineSilence::update(const BusSettings& settings) {
  frame_gap_ = settings.frame_gap.value_or(timing_.t3_5());
  turnaround_ = settings.turnaround;
  settle_ = settings.settle;
}

void LineSilence::open(Instant now, Instant listen_until) {
  quiet_since_ = now;
  busy_since_ = now;
  emission_ends_ = now;
  listening_until_ = listen_until;
  settling_until_ = now;
  turnaround_until_ = std::max(turnaround_until_, now);  // the drives know nothing of the adapter
}

void LineSilence::note_frame(std::size_t bytes, Instant now) {
  emission_ends_ = now + timing_.duration_of(bytes);
  quiet_since_ = emission_ends_;
  busy_since_ = emission_ends_;
}

void LineSilence::note_bytes(Instant now) {
  if (now > quiet_since_ + frame_gap_) {
    busy_since_ = now;
  }
  quiet_since_ = std::max(quiet_since_, now);
}

}  // namespace mbgate::bus
