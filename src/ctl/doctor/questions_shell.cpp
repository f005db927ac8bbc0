// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/questions_shell.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace mbgate::ctl {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

constexpr const char* kEndedBySignal = "interrupted";
/// A signal waits no longer than this while the idle line is listened to.
constexpr std::chrono::milliseconds kListenedAtOnce{100};
/// Of the idle line: enough to see what it looks like.
constexpr std::size_t kMostKept = 4096;
/// The answer of a second device begins by then.
constexpr std::chrono::milliseconds kSecondAnswer{100};
/// A serial device server on a wireless network may pause so long within a frame.
constexpr std::chrono::milliseconds kRestOfFrame{300};

void keep_pieces(const std::vector<Piece>& pieces, IdleLine& idle) {
  for (const auto& piece : pieces) {
    idle.bytes += piece.bytes.size();
    if (idle.heard.size() < kMostKept) {
      idle.heard.insert(idle.heard.end(), piece.bytes.begin(), piece.bytes.end());
    }
  }
}

std::vector<std::uint8_t> asked_units(const Answers& answers) {
  std::vector<std::uint8_t> addresses;
  std::ranges::transform(answers.units, std::back_inserter(addresses),
                         [](const UnitTrials& unit) { return unit.unit.address; });
  return addresses;
}

/// What is to be said of what came since the last request.
Unasked& since_last(Answers& answers) {
  return answers.units.empty() ? answers.before : answers.units.back().trials.back().after;
}

}  // namespace

Questions::Questions(const LinePlan& plan, const DoctorCommand& command, SerialClient client,
                     const Interruption& interruption)
    : plan_(plan),
      command_(command),
      read_{modbus::Table::holding_registers, command.holding_register, 1},
      client_(std::move(client)),
      interruption_(interruption) {}

std::optional<std::string> Questions::listen(IdleLine& idle) {
  if (interruption_.wait_until(client_.ready_at())) {
    return kEndedBySignal;
  }
  return hear(command_.listen, idle);
}

std::optional<std::string> Questions::ask(Answers& answers) {
  for (const auto& unit : plan_.units) {
    if (auto error = ask_unit(unit, answers); error || is_foreign_) {
      return error;
    }
  }
  return std::nullopt;
}

std::optional<std::string> Questions::hear(nanoseconds time, IdleLine& idle) {
  const auto begin = steady_clock::now();
  const auto heard_before = idle.time;
  for (nanoseconds passed{0}; passed < time; passed = steady_clock::now() - begin) {
    const auto pieces = client_.overhear(std::min<nanoseconds>(kListenedAtOnce, time - passed));
    if (!pieces) {
      return pieces.error();
    }
    keep_pieces(*pieces, idle);
    if (interruption_.wait_until(begin)) {
      return kEndedBySignal;
    }
  }
  idle.time = heard_before + time;
  return std::nullopt;
}

std::optional<std::string> Questions::look(Answers& answers, nanoseconds time) {
  IdleLine line;
  const auto pieces = client_.overhear(nanoseconds(0));
  if (!pieces) {
    return pieces.error();
  }
  keep_pieces(*pieces, line);
  const nanoseconds rest = line.bytes > 0 ? nanoseconds(kRestOfFrame) : nanoseconds(0);
  if (auto error = hear(std::max(time, rest), line)) {
    return error;
  }
  const auto unasked = understand_unasked(read_, asked_units(answers), line.heard);
  auto& known = since_last(answers);
  known.late_answers += unasked.late_answers;
  if (unasked.is_foreign()) {
    known.bytes = unasked.bytes;
    known.other_client = unasked.other_client;
    is_foreign_ = true;
  }
  if (line.bytes > 0 && interruption_.wait_until(client_.ready_at())) {
    return kEndedBySignal;
  }
  return std::nullopt;
}

std::optional<std::string> Questions::ask_once(const PlannedUnit& unit, Answers& answers) {
  const SentRead sent(unit.address, read_);
  bool interrupted = false;
  const auto pieces = client_.ask_all(sent, {answer_wait(unit), kSecondAnswer, kRestOfFrame}, [&] {
    interrupted = interrupted || interruption_.wait_until(steady_clock::now());
    return interrupted;
  });
  if (!pieces) {
    return pieces.error();
  }
  if (interrupted) {
    return kEndedBySignal;
  }
  if (answers.units.empty() || answers.units.back().unit.address != unit.address) {
    answers.units.push_back({unit});
  }
  answers.units.back().trials.push_back(understand(sent, *pieces));
  is_foreign_ = is_foreign_ || !answers.units.back().trials.back().other_client.empty();
  return std::nullopt;
}

std::optional<std::string> Questions::settle(const PlannedUnit& unit, Answers& answers) {
  auto& trials = answers.units.back().trials;
  if (trials.back().kind != HeardKind::answer || owed_answers(trials) == 0) {
    return std::nullopt;
  }
  auto error = look(answers, answer_wait(unit) + kRestOfFrame);
  trials.back().settled = !error;
  return error;
}

std::optional<std::string> Questions::ask_unit(const PlannedUnit& unit, Answers& answers) {
  for (std::size_t asked = 0; asked < command_.requests; ++asked) {
    if (interruption_.wait_until(client_.ready_at() + unit.pause)) {
      return kEndedBySignal;
    }
    if (auto error = look(answers, nanoseconds(0)); error || is_foreign_) {
      return error;
    }
    if (auto error = ask_once(unit, answers); error || is_foreign_) {
      return error;
    }
    if (is_given_up(answers.units.back().trials)) {
      return std::nullopt;
    }
    if (auto error = settle(unit, answers); error || is_foreign_) {
      return error;
    }
  }
  return std::nullopt;
}

}  // namespace mbgate::ctl
