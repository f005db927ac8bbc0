// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/sweep.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <span>
#include <utility>

#include "base/text.hpp"
#include "config/toml/toml_value.hpp"
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

std::string at(const ModeFindings& found) { return fmt::format("at {} ", mode_text(found.mode)); }

std::string frames_text(const ModeFindings& found) {
  return fmt::format(
      "{}frames of {} came late or without a request: a longer --wait may help, or another client "
      "is on the line",
      at(found), units_text(found.others));
}

std::string noise_text(const ModeFindings& found) {
  std::string text =
      fmt::format("{}{} heard that {} not an answer: ", at(found),
                  counted(found.noise_bytes, "byte"), found.noise_bytes == 1 ? "is" : "are");
  if (found.bad_crcs > 0) {
    text += fmt::format("{} with a bad CRC{}", counted(found.bad_crcs, "frame"),
                        found.noise > 0 ? ", and " : ", as if two units had one address");
  }
  if (found.noise > 0) {
    text += "no frame after " + counted(found.noise, "request");
  }
  return text;
}

/// What came of the read of one unit. `asked`: all that were asked in this mode, this one last.
void note(ModeFindings& found, std::span<const std::uint8_t> asked, const Heard& heard) {
  switch (heard.kind) {
    case HeardKind::silence: break;
    case HeardKind::answer: insert_once(found.units, asked.back()); break;
    case HeardKind::other_frame:
      insert_once(found.others, heard.unit);
      // A late answer is one too: the wait was too short, not the mode wrong.
      if (std::ranges::find(asked, heard.unit) != asked.end()) {
        insert_once(found.units, heard.unit);
      }
      break;
    case HeardKind::bad_crc: ++found.bad_crcs; break;
    case HeardKind::noise: ++found.noise; break;
  }
  if (heard.kind == HeardKind::bad_crc || heard.kind == HeardKind::noise) {
    found.noise_bytes += heard.bytes;
  }
}

}  // namespace

Sweep::Sweep(SweepPlan plan) : plan_(std::move(plan)) {}

std::optional<std::string> Sweep::ask_all(ModeFindings& found, const SweptLine& line) {
  for (std::size_t at = 0; at < plan_.units.size(); ++at) {
    line.progress(fmt::format("{} ({} of {}): asking unit {}, {} found", mode_text(found.mode),
                              findings_.size(), plan_.port.modes.size(), plan_.units[at],
                              found.units.size()));
    const auto heard = line.ask(plan_.units[at]);
    if (!heard) {
      return heard.error();
    }
    note(found, std::span(plan_.units).first(at + 1), *heard);
  }
  return std::nullopt;
}

std::optional<std::string> Sweep::run(const SweptLine& line) {
  if (plan_.units.empty()) {
    return std::nullopt;
  }
  for (const auto& mode : plan_.port.modes) {
    ModeFindings& found = findings_.emplace_back(ModeFindings{mode});
    found.refusal = line.set_mode(mode);
    auto error = found.refusal ? std::nullopt : ask_all(found, line);
    if (error || (!found.units.empty() && !plan_.port.all_modes)) {
      return error;
    }
  }
  return std::nullopt;
}

const ModeFindings* Sweep::best() const {
  const auto answered = [](const ModeFindings& found) { return found.units.size(); };
  const auto most = std::ranges::max_element(findings_, {}, answered);
  return most == findings_.end() || most->units.empty() ? nullptr : &*most;
}

std::chrono::nanoseconds longest(const SweepPlan& plan) {
  std::chrono::nanoseconds time{0};
  for (const auto& mode : plan.port.modes) {
    const modbus::RtuTiming timing(mode.baud, mode.format);
    const auto each = timing.duration_of(kFrames) + plan.port.wait + timing.t3_5();
    time += kModeSettling + each * static_cast<std::int64_t>(plan.units.size());
  }
  return time;
}

std::string sweep_announcement(const SweepPlan& plan) {
  const auto most = std::chrono::ceil<std::chrono::seconds>(longest(plan));
  std::string text =
      fmt::format("asking {} at {}", counted(plan.units.size(), "unit"), plan.port.device);
  if (plan.port.modes.size() == 1) {
    text += " at " + mode_text(plan.port.modes.front());
  } else {
    text += fmt::format(" in {}, {} first", counted(plan.port.modes.size(), "mode"),
                        mode_text(plan.port.modes.front()));
  }
  return fmt::format("{}: {} at most, and some seconds for each that answers; only reads are sent",
                     text, config::to_text(most));
}

std::vector<std::string> sweep_notes(const Sweep& sweep) {
  std::vector<std::string> notes;
  for (const auto& found : sweep.findings()) {
    if (found.refusal) {
      notes.push_back(mode_text(found.mode) + " was left out: " + *found.refusal);
    }
    if (!found.others.empty()) {
      notes.push_back(frames_text(found));
    }
    if (found.noise_bytes > 0) {
      notes.push_back(noise_text(found));
    }
    if (!found.units.empty() && &found != sweep.best()) {
      notes.push_back(fmt::format(
          "{}{} answered too, and {} not identified: scan again with only this rate and parity",
          at(found), units_text(found.units), found.units.size() == 1 ? "was" : "were"));
    }
  }
  return notes;
}

std::string nobody_text(const Sweep& sweep) {
  const auto tried =
      std::ranges::count_if(sweep.findings(), [](const auto& found) { return !found.refusal; });
  const std::string modes = tried == 1 && sweep.findings().size() == 1
                                ? "at " + mode_text(sweep.findings().front().mode)
                                : "in " + counted(static_cast<std::size_t>(tried), "mode");
  return fmt::format("no unit answered at {} {}", sweep.plan().port.device, modes);
}

std::string units_text(const std::vector<std::uint8_t>& units) {
  std::string text = units.size() == 1 ? "unit " : "units ";
  for (std::size_t first = 0; first < units.size();) {
    std::size_t last = first;
    while (last + 1 < units.size() && units[last + 1] == units[last] + 1) {
      ++last;
    }
    text.append(first == 0 ? "" : ", ").append(std::to_string(units[first]));
    if (last > first) {
      text += fmt::format("-{}", units[last]);
    }
    first = last + 1;
  }
  return text;
}

}  // namespace mbgate::ctl
