// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/sweep.hpp"

#include <algorithm>
#include <utility>

#include "ctl/serial/serial_client.hpp"

namespace mbgate::ctl {
namespace {

/// The request and its answer: 8 and 7 bytes.
constexpr std::size_t kFrames = 15;

void insert_once(std::vector<std::uint8_t>& units, std::uint8_t unit) {
  const auto place = std::ranges::lower_bound(units, unit);
  if (place == units.end() || *place != unit) {
    units.insert(place, unit);
  }
}

}  // namespace

Sweep::Sweep(SweepPlan plan) : plan_(std::move(plan)) {}

std::optional<Sweep::Step> Sweep::next() const {
  if (mode_ >= plan_.modes.size() || plan_.units.empty()) {
    return std::nullopt;
  }
  return Step{plan_.modes[mode_], unit_ == 0, plan_.units[unit_]};
}

bool Sweep::is_asked(std::uint8_t unit) const {
  const auto end = plan_.units.begin() + static_cast<std::ptrdiff_t>(unit_) + 1;
  return std::find(plan_.units.begin(), end, unit) != end;
}

void Sweep::end_mode() {
  const bool answered = !findings_.back().units.empty();
  mode_ = answered && !plan_.all_modes ? plan_.modes.size() : mode_ + 1;
  unit_ = 0;
}

void Sweep::take(const Heard& heard) {
  if (unit_ == 0) {
    findings_.push_back({plan_.modes[mode_]});
  }
  auto& found = findings_.back();
  switch (heard.kind) {
    case HeardKind::silence: break;
    case HeardKind::answer: insert_once(found.units, plan_.units[unit_]); break;
    case HeardKind::other_frame:
      insert_once(found.others, heard.unit);
      // A late answer is one too: the wait was too short, not the mode wrong.
      if (is_asked(heard.unit)) {
        insert_once(found.units, heard.unit);
      }
      break;
    case HeardKind::bad_crc: ++found.bad_crcs; break;
    case HeardKind::noise: ++found.noise; break;
  }
  if (heard.kind == HeardKind::bad_crc || heard.kind == HeardKind::noise) {
    found.noise_bytes += heard.bytes;
  }
  if (++unit_ == plan_.units.size()) {
    end_mode();
  }
}

void Sweep::refuse_mode(std::string why) {
  findings_.push_back({plan_.modes[mode_]});
  findings_.back().refusal = std::move(why);
  end_mode();
}

const ModeFindings* Sweep::best() const {
  const auto answered = [](const ModeFindings& found) { return found.units.size(); };
  const auto most = std::ranges::max_element(findings_, {}, answered);
  return most == findings_.end() || most->units.empty() ? nullptr : &*most;
}

std::chrono::nanoseconds longest(const SweepPlan& plan) {
  std::chrono::nanoseconds time{0};
  for (const auto& mode : plan.modes) {
    const modbus::RtuTiming timing(mode.baud, mode.format);
    const auto each = timing.duration_of(kFrames) + plan.wait + timing.t3_5();
    time += kModeSettling + each * static_cast<std::int64_t>(plan.units.size());
  }
  return time;
}

std::optional<std::string> carry_out_sweep(Sweep& sweep, const SweptLine& line) {
  while (const auto step = sweep.next()) {
    if (step->sets_mode) {
      if (auto why = line.set_mode(step->mode)) {
        sweep.refuse_mode(*std::move(why));
        continue;
      }
    }
    line.progress(sweep);
    const auto heard = line.ask(step->unit);
    if (!heard) {
      return heard.error();
    }
    sweep.take(*heard);
  }
  return std::nullopt;
}

}  // namespace mbgate::ctl
