// SPDX-License-Identifier: Apache-2.0
// Handles each parsed request: the gateway answers it itself, or starts it on the buses and answers
// it when all its jobs have ended.
#pragma once

#include "gateway/access/report_limit.hpp"
#include "gateway/clients/intake.hpp"
#include "gateway/clients/sessions.hpp"
#include "gateway/exchanges/exchanges.hpp"
#include "gateway/status_unit.hpp"
#include "gateway/trace/trace_book.hpp"
#include "gateway/writes/failsafe_writes.hpp"

namespace mbgate::gateway {

class Requests {
 public:
  Requests(const SettingsHistory& settings, BusSet& buses, Exchanges& exchanges, WriteRules& rules,
           FailsafeWrites& failsafe, Sessions& sessions, Intake& intake, TraceBook& trace,
           ActionQueue& actions, Instant now)
      : settings_(settings),
        buses_(buses),
        exchanges_(exchanges),
        rules_(rules),
        failsafe_(failsafe),
        sessions_(sessions),
        intake_(intake),
        trace_(trace),
        actions_(actions),
        started_(now) {}

  /// Answers the request or starts it. The plan is moved out of it.
  void accept(ClientSession& session, Request& request, Instant now);
  /// All jobs of the exchange have ended: answers it.
  void complete(std::uint32_t exchange, Instant now);
  /// The first deadline of what is held; nothing: nothing is.
  [[nodiscard]] std::optional<Instant> first_deadline(const ClientSession& session) const;
  /// Refuses what is held beyond its deadline.
  void end_overdue(const ClientSession& session, Instant now);
  /// New settings are in force: takes back what waits of the client and may not be asked any more,
  /// and of what no bus has yet, refuses what would mean something else now.
  void end_unwanted(const ClientSession& session, const SettingsSnapshot& before, Instant now);
  /// All that the status unit shows: of its own, of clients, of buses and devices.
  void clear_counters();

 private:
  void answer_at_once(ClientSession& session, const Request& request, const modbus::Pdu& answer,
                      Instant now);
  void begin(ClientSession& session, Request& request, Instant now);
  /// Of a broadcast the journal is told which devices it is not for.
  void say_left_out(const ClientSession& session, const Request& request);
  [[nodiscard]] bool is_withdrawn(const ClientSession& session, const Exchange& exchange,
                                  Instant now) const;
  void replace_unanswered(ClientSession& session);
  void start_held(ClientSession& session, Instant now);
  [[nodiscard]] modbus::Pdu answer_of_gateway(const ClientSession& session, const Request& request,
                                              Instant now);
  void send(ClientSession& session, AnswerId id, const std::optional<DueAnswers::Answer>& answer,
            Instant now);

  const SettingsHistory& settings_;
  BusSet& buses_;
  Exchanges& exchanges_;
  WriteRules& rules_;
  FailsafeWrites& failsafe_;
  Sessions& sessions_;
  Intake& intake_;
  TraceBook& trace_;
  ActionQueue& actions_;
  StatusUnit status_unit_;
  ReportLimit clears_{kActsReported};
  ReportLimit misreads_{kDenialsReported};
  Instant started_;
};

}  // namespace mbgate::gateway
