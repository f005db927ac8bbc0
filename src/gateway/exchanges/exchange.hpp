// SPDX-License-Identifier: Apache-2.0
// A client request from its acceptance to its answer, with the results of its jobs so far.
#pragma once

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <optional>

#include "bus/job.hpp"
#include "gateway/action.hpp"
#include "gateway/client.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "modbus/mbap.hpp"
#include "routing/plan.hpp"

namespace mbgate::gateway {

/// A failsafe write is an exchange too, without a client and without a plan.
struct Exchange {
  struct Part {
    BusId bus;
    bus::Job* job;
    /// As its bus has classified it.
    [[nodiscard]] bool is_stop() const { return job->job_class == bus::JobClass::stop; }
  };

  SettingsSnapshot* snapshot = nullptr;           ///< that the plan was made with; set while in use
  const routing::ResolvedRoute* route = nullptr;  ///< in that one
  ClientId client{};
  ListenerId listener{};  ///< its number in the settings in force
  routing::ClientAddress address;
  bool client_gone = false;
  Instant arrival;
  Instant deadline;            ///< nothing of it is begun afterwards
  std::uint64_t sequence = 0;  ///< of all requests that were accepted
  bool is_stop = false;
  bool is_held = false;      ///< beyond `pipeline`: no bus has it yet
  bool is_replaced = false;  ///< its client has asked something else: it gets no answer
  AnswerId answer{};
  modbus::MbapHeader header;
  std::optional<routing::Plan> plan;
  boost::container::small_vector<Part, 1> parts;  ///< jobs that have not ended
  std::optional<modbus::Pdu> response;
  bool failed = false;
  bool was_on_wire = false;
  bool wrong_word_order = false;  ///< the drive's own setting is not the configured one
  bool had_no_path = false;       ///< a line was not open and nothing of that part was transmitted
  std::optional<bus::Ending> ended_as;  ///< its last job, or the first that failed

  /// The transactions of its plan.
  [[nodiscard]] std::size_t planned() const { return plan ? plan->transactions().size() : 0; }
  /// Takes over how a job ended.
  void note(const bus::Job& job, bus::Ending ending);
  /// The answer, once every part has ended; nothing if none is to be given.
  [[nodiscard]] std::optional<modbus::Pdu> result() const;
};

/// New settings: would the job mean something else now? Its unit may have another route or none, or
/// its device may have changed.
[[nodiscard]] bool means_otherwise(const Exchange& exchange, const Exchange::Part& part,
                                   const SettingsSnapshot& old, const SettingsSnapshot& next);

/// To be called when a job has ended. The settings are those in which the job's bus has its number.
void report_effects(const Exchange& exchange, const Exchange::Part& part, bus::Ending ending,
                    const Settings& settings, ActionQueue& actions);

}  // namespace mbgate::gateway
