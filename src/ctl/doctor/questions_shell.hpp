// SPDX-License-Identifier: Apache-2.0
// Listens to a line, and asks its units one after the other. It ends if another client may be on
// the line, because its requests would damage that client's frames.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ctl/doctor/findings.hpp"
#include "ctl/doctor/trial.hpp"
#include "ctl/request/repetition.hpp"
#include "ctl/serial/serial_client.hpp"

namespace mbgate::ctl {

/// What came of the whole line.
struct Answers {
  Unasked before{};                 ///< before anything was sent
  std::vector<UnitTrials> units{};  ///< those that were asked at all
};

class Questions {
 public:
  /// `client` has its mode. All else must live as long as this does.
  Questions(const LinePlan& plan, const DoctorCommand& command, SerialClient client,
            const Interruption& interruption);

  /// To the idle line, as long as the command says. What ended it early, if anything did.
  std::optional<std::string> listen(IdleLine& idle);
  /// Asks all units of the plan in turn, until another client is heard, or may have been: then that
  /// is in `answers`. What ended it early otherwise, if anything did.
  std::optional<std::string> ask(Answers& answers);

 private:
  std::optional<std::string> hear(std::chrono::nanoseconds time, IdleLine& line);
  /// Takes what came since the last request, and what comes within `time`.
  std::optional<std::string> look(Answers& answers, std::chrono::nanoseconds time);
  std::optional<std::string> ask_once(const PlannedUnit& unit, Answers& answers);
  /// Where it cannot be known which request an answer was to, waits until none is owed any more.
  std::optional<std::string> settle(const PlannedUnit& unit, Answers& answers);
  std::optional<std::string> ask_unit(const PlannedUnit& unit, Answers& answers);

  const LinePlan& plan_;
  const DoctorCommand& command_;
  modbus::TableRange read_;
  SerialClient client_;
  const Interruption& interruption_;
  bool is_foreign_ = false;
};

}  // namespace mbgate::ctl
