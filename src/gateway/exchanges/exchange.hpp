// SPDX-License-Identifier: Apache-2.0
// A client request from its acceptance to its answer, and what its jobs have come to so far.
#pragma once

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <optional>

#include "bus/job.hpp"
#include "gateway/client.hpp"
#include "gateway/settings/device_index.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "modbus/mbap.hpp"
#include "routing/plan.hpp"

namespace mbgate::gateway {

/// A failsafe write is one too: without a client and without a plan.
struct Exchange {
  struct Part {
    BusId bus;
    bus::Job* job;
    /// As its bus has found it.
    [[nodiscard]] bool is_stop() const { return job->job_class == bus::JobClass::stop; }
  };

  SettingsSnapshot* snapshot = nullptr;           ///< that the plan was made with; set while in use
  const routing::ResolvedRoute* route = nullptr;  ///< in that one
  ClientId client{};
  ListenerId listener{};  ///< as the settings in force count them
  routing::ClientAddress address;
  bool client_gone = false;
  bool is_stop = false;  ///< one of its parts is: that one goes on without its client
  /// Of a stop that is one on some buses only: those on which its part may not be transmitted.
  BusList left_out;
  AnswerId answer{};
  modbus::MbapHeader header;
  std::optional<routing::Plan> plan;
  boost::container::small_vector<Part, 1> parts;  ///< jobs that have not ended
  std::optional<modbus::Pdu> response;
  bool failed = false;
  bool was_on_wire = false;
  bool wrong_word_order = false;  ///< the drive's own setting is not the one configured
  bool had_no_path = false;       ///< a line was not there and nothing of that part was transmitted

  [[nodiscard]] bool leaves_out(BusId bus) const {
    return std::ranges::find(left_out, bus) != left_out.end();
  }
  /// Was anything of it transmitted?
  [[nodiscard]] bool has_been_on_wire() const {
    return was_on_wire ||
           std::ranges::any_of(parts, [](const Part& part) { return part.job->was_on_wire; });
  }
  /// Takes in what became of a job.
  void note(const bus::Job& job, bus::Ending ending);
  /// The answer, once every part has ended; nothing if none is to be given.
  [[nodiscard]] std::optional<modbus::Pdu> result() const;
};

/// Other settings: would the job mean something else now? Its unit may lead to another device or to
/// none, or its device may be another one.
[[nodiscard]] bool means_otherwise(const Exchange& exchange, const Exchange::Part& part,
                                   const SettingsSnapshot& old, const SettingsSnapshot& next);

}  // namespace mbgate::gateway
