// SPDX-License-Identifier: Apache-2.0
// Knows what is right. It sees what clients write and get and what goes over the wires, nothing of
// the product's inside; whom a transmission is for it works out from the frame. Where several
// requests may be meant (shared reads), it takes the one that makes the product right.
#pragma once

#include <deque>
#include <memory>
#include <string>

#include "gateway/event.hpp"
#include "soak/asked.hpp"
#include "soak/client_rates.hpp"
#include "soak/device.hpp"
#include "soak/failsafe_watch.hpp"
#include "soak/flight.hpp"
#include "soak/from_world.hpp"
#include "soak/meanings.hpp"
#include "soak/oracle_books.hpp"
#include "soak/report.hpp"
#include "soak/rule_rates.hpp"
#include "soak/specification.hpp"
#include "soak/writer_rules.hpp"

namespace mbgate::soak {

using modbus::Bytes;

class Oracle {
 public:
  using Devices = std::deque<SoakDevice>;  // as in the settings
  Oracle(const SoakPlan& plan, const Devices& devices, const Schedule& schedule, Report& report);

  // oracle_clients.cpp
  void connect(ClientId client, std::size_t listener, unsigned host, bool has_tls);
  /// The first byte was put into the socket at `written`. Returns its number.
  std::uint64_t ask(ClientId client, Asked asked);
  /// The gateway has its first byte, and its last.
  void begun(std::uint64_t id);
  void delivered(ClientId client, std::uint64_t id);
  void answer_sent(ClientId client);
  /// What it writes from then on counts as old as the pause, until its socket was seen empty.
  void paused(ClientId client);  // oracle_stalls.cpp
  void seen_empty(ClientId client, Instant at);
  /// The process did not run since then, and says so to the gateway.
  void stalled(Instant since);
  void half_closed(ClientId client);
  void gone(ClientId client, const char* how = "for_gone_client");
  /// The gateway has closed a half-closed connection: nothing of it may be open.
  void closed(ClientId client);
  void answered(ClientId client, Bytes adu);
  [[nodiscard]] std::size_t open_of(ClientId client) const;
  /// Does the gateway surely have a request of it that it has not answered, or not yet sent?
  [[nodiscard]] bool has_outstanding(ClientId client) const;
  /// Has it surely none?
  [[nodiscard]] bool is_idle(ClientId client) const;
  /// Is the transaction identifier in use?
  [[nodiscard]] bool is_open(ClientId client, std::uint16_t transaction) const;
  /// Requests with a good answer so far: a glance for the quiet phase.
  [[nodiscard]] bool was_answered_well(std::uint64_t id) const { return well_ && *well_ == id; }
  /// The data of the last answer of the status unit.
  [[nodiscard]] const PduBytes& own_answer() const { return own_answer_; }

  // oracle_shutdown.cpp: the gateway is told to stop, says that it has, and must have by now.
  void begin_shutdown();
  void finished();
  void check_stopped();

  // oracle_wire.cpp
  void bus_opened(std::size_t bus);
  /// The connection that a server has closed now was open for long, and nothing was asked on it.
  [[nodiscard]] bool was_idle(std::size_t bus) const;
  void bus_lost(std::size_t bus);
  void bus_opening(std::size_t bus);
  /// It rests, and may be opened now: the turn of a request may have come, and nobody was told.
  [[nodiscard]] bool may_be_wanted(std::size_t bus);
  /// The server has closed a connection on which it has answered: what waits goes on waiting.
  void tcp_closed(std::size_t bus);
  /// The gateway gives a connection up because nothing comes, or opens such a line again.
  void line_replaced(std::size_t bus);
  /// The gateway begins to transmit.
  Flight& transmitted(std::size_t bus, Bytes frame);
  [[nodiscard]] Flight* flight(std::uint64_t number) const;
  void executed(const Flight& flight);
  void excepted(const Flight& flight, std::uint8_t code);
  /// The line heard it differently than it was sent: no answer to it counts.
  void echo_spoilt(const Flight& flight);
  void echo_lost(const Flight& flight);  ///< nothing of it is heard
  [[nodiscard]] bool takes_answers_for_echoes(std::size_t bus) const;
  /// Bytes have reached the kernel, where the gateway can read them.
  void bytes_came(std::size_t bus, Bytes bytes);
  void bytes_handed_in(std::size_t bus);  ///< it has read them
  void deadline_handed_in() { judged_ = schedule_.now(); }
  /// A whole good frame has reached the kernel.
  void frame_came(std::size_t bus, HeardFrame frame);
  /// The request of another client has reached the kernel.
  void stranger_asked(std::size_t bus) { books_[bus].unread_stranger = true; }
  /// The end of an echo has reached the kernel.
  void echo_came(std::size_t bus, const HeardEcho& echo) { books_[bus].unread_echo = echo; }
  void line_news(std::size_t bus, bus::LineFault fault);  ///< what the gateway says of the line
  /// The TCP answer with the identifier was handed to it.
  void tcp_answer_came(std::uint64_t number);
  /// The server begins an answer that names another unit, and the gateway has not read it yet.
  void misnamed(std::size_t bus, std::uint64_t number) { books_[bus].misnamed.push_back(number); }
  [[nodiscard]] bool has_misnamed(std::size_t bus) const { return !books_[bus].misnamed.empty(); }
  /// An answer of the device may still be taken for one to the gateway.
  [[nodiscard]] bool owes(std::size_t bus, std::uint8_t address);
  [[nodiscard]] Past take_past();
  /// Another process has been started.
  void begin_with(Past past);
  // oracle_reload.cpp
  void before_reload();  ///< what is known only by the settings that end now
  /// The bus's line is given up, or the bus itself: the next one under its name begins anew.
  void line_given_up(std::size_t bus);
  /// Of the bus or a device on it other times or rules hold now.
  void touched(std::size_t bus);
  /// What waits for the device at the address, or for all on its bus, is not what was meant.
  void take_back(std::size_t bus, std::uint8_t address);
  /// The settings of the plan are in force.
  void after_reload();
  /// The gateway has done all that it does at once.
  void check_taken_back();
  /// No request through the door is on its way into the gateway, or may be.
  [[nodiscard]] bool is_settled(const Door& door) const;
  /// The same, or the gateway has at least begun to read each of them before.
  [[nodiscard]] bool is_within(const Door& door) const;
  /// It is not known of every request whether the gateway has accepted it.
  [[nodiscard]] bool is_unsure(const Door& door) const;
  /// Is the device at the address left alone because of an answer that may still come?
  [[nodiscard]] bool is_quarantined(std::size_t bus, std::uint8_t address) const;
  /// To be called after every input of the gateway: what has waited too long, what is too much.
  void check_waiting();
  void check_overdue();
  /// A stop still waits or goes on; everything must be over.
  [[nodiscard]] bool has_stops() const;
  void check_finished();
  void trace() { traced_ = true; }
  void violation(const std::string& kind, const std::string& text) const;
  /// Since its line is what it is.
  [[nodiscard]] const BusCount& count(std::size_t bus) const { return books_[bus].count; }
  [[nodiscard]] const BusCount& count(std::size_t bus, std::uint8_t address) const;
  /// Requests that the gateway has taken, and of how many that is not sure.
  [[nodiscard]] std::uint64_t accepted() const { return sequence_; }
  [[nodiscard]] std::uint64_t perhaps_accepted() const { return perhaps_accepted_; }
  [[nodiscard]] ClientRates& client_rates() { return client_rates_; }

 private:
  friend class HeardAnswers;
  friend class BootRules;
  friend class Refusals;
  friend class SharedReads;
  friend class Withdrawals;
  friend class WordOrders;
  // oracle_clients.cpp
  void accept_backlog(Session& session);
  void look_ahead(Session& session);
  void forget_gone_stops();
  void accept(Asked& asked);
  // oracle_failsafe.cpp
  void note_failsafe_asked(const Asked& asked);
  void note_failsafe_sent(Flight& flight);
  void note_done_for_failsafe(const Flight& flight);
  [[nodiscard]] bool has_failsafe(std::size_t bus) const;
  void check_failsafes() const;
  [[nodiscard]] std::vector<Asked*> broadcasts_on(std::size_t bus);
  void close(Asked& asked, const std::string& how);
  void end_without_reply(Asked& asked);
  void note_write_event(const Asked& asked, std::optional<std::size_t> bus = std::nullopt);
  void leave_queue(Piece& piece);
  /// Of answers that are held back only the oldest request is known to be open.
  [[nodiscard]] bool is_surely_open(const Asked& asked) const;
  // oracle_reload.cpp
  void note_allowed(Asked& asked) const;
  [[nodiscard]] std::optional<drive::WordOrder> order_of(const Door& door) const;
  [[nodiscard]] bool is_past_offline(std::size_t bus, const Lane& lane) const;
  void note_alive(std::size_t bus, Lane& lane) const;
  void map_lanes();
  void take_back(Asked& asked, std::size_t bus);
  [[nodiscard]] bool is_outdated(const Asked& asked) const;
  // oracle_answers.cpp
  void judge(Asked& asked, Bytes pdu);
  void device_answered(const Asked& asked, bool may_be_kept);
  void judge_exception(const Asked& asked, std::uint8_t code);
  void judge_cut(const Asked& asked);
  void judge_data(const Asked& asked, Bytes pdu);
  void judge_bits(const Asked& asked, Bytes pdu);
  void judge_done(const Asked& asked);
  void judge_content(const Asked& asked, Bytes pdu);
  void judge_identity(const Asked& asked, Bytes pdu);
  void judge_echo(const Asked& asked, Bytes pdu);
  [[nodiscard]] Span span_of(const Asked& asked) const;
  void judge_place(const Asked& asked);
  [[nodiscard]] bool is_apart(const Asked& asked, const char* what);
  void wrong_data(const Asked& asked, const std::string& text);
  [[nodiscard]] bool may_be_offline(const Asked& asked) const;
  // oracle_wire.cpp
  bool take_apart(Bytes frame, Flight& flight);
  [[nodiscard]] Duration listens_for(std::size_t bus) const;
  void check_silence(const Flight& flight);
  void note_debt(const Flight& flight);
  void attribute(Flight& flight);
  bool fits(const Asked& asked, const Piece& piece, const Flight& flight) const;
  [[nodiscard]] std::string objection(const Asked& asked, const Piece& piece);
  void unknown_transmission(Flight& flight);
  void note_sent(Asked& asked, Piece& piece, const Flight& flight, bool alone);
  void check_order(const Asked& asked, const Flight& flight);
  void check_tcp(const Flight& flight);
  void note_crowded(std::size_t bus);
  void check_rest(std::size_t bus);
  void cut_flying(const Book& book);
  [[nodiscard]] Instant deadline_of(const Flight& flight) const;
  void set_times(Flight& flight);
  // oracle_debts.cpp
  [[nodiscard]] bool is_only_debt(const Lane& lane, const HeardFrame& frame) const;
  [[nodiscard]] static Duration owed_for(const Flight& flight);
  [[nodiscard]] bool has_second(const Lane& lane) const;
  void settle(std::size_t bus, const HeardFrame& frame);
  void note_second(Lane& lane, const HeardFrame& frame, const Flight* from);
  [[nodiscard]] Duration shown(const Lane& lane) const;
  [[nodiscard]] const char* root_of(const Lane& lane, const HeardFrame& frame, const Flight* from,
                                    bool is_strange) const;
  void note_uncertain(std::size_t bus, const HeardFrame& frame);
  void count_slip(const Asked& asked);  // oracle_slips.cpp
  // oracle_echo.cpp
  void read_frames(std::size_t bus);
  void read_answers(std::size_t bus);
  [[nodiscard]] bool is_for_last(const Book& book, const HeardFrame& frame);
  [[nodiscard]] bool stands_for_echo(const Book& book);
  void note_heard(Book& book, const HeardFrame& frame);
  void read_echo(std::size_t bus);
  void note_echo_for_answer(std::size_t bus, Flight& flight, const HeardEcho& echo);
  [[nodiscard]] bool began_while_sending(std::size_t bus, Instant began) const;
  void judge_heard(const Asked& asked);
  [[nodiscard]] bool is_excused(const Asked& asked);
  void check_told(const Book& book, std::size_t bus) const;
  // oracle_stops.cpp
  [[nodiscard]] bool lets_writes_go(const Asked& stop) const;
  void check_stops_first(const Flight& flight);
  void note_stops(Flight& flight);
  [[nodiscard]] Duration stop_deadline(std::size_t bus) const;
  [[nodiscard]] bool may_break_silence(const Flight& flight);
  void check_stops_waiting(std::size_t bus);
  // oracle_times.cpp
  void note_whole(std::size_t bus, HeardFrame& frame) const;
  void note_answered(std::size_t bus, const HeardFrame& frame);
  void note_use(const Flight& flight);
  [[nodiscard]] Duration lateness() const;
  void check_bounds(const Flight& flight, const Flight* before);
  void judge_eviction(const Asked& asked);
  void note_loss(std::size_t bus);
  void check_reopening(std::size_t bus);
  // oracle_offline.cpp
  [[nodiscard]] bool is_surely_offline(const Lane& lane) const;
  void note_silent(std::size_t bus);
  // oracle_tries.cpp
  void check_answered(const Asked& asked);
  void check_pause(const Asked& asked, const Flight& flight);
  void judge_tries(const Asked& asked);
  [[nodiscard]] bool was_silent(const Asked& asked) const;
  void check_tries(const Asked& asked) const;
  void judge_cached(const Asked& asked);
  // oracle_counts.cpp
  void note_counts(const Flight& flight);
  void note_excused(const Flight& flight);
  void note_interrupted(Book& book);
  void note_cut(Book& book);
  [[nodiscard]] std::string name(const Asked& asked) const;
  [[nodiscard]] std::string name(const Flight& flight) const;
  [[nodiscard]] const gateway::BusSettings& bus_settings(std::size_t bus) const;
  [[nodiscard]] bool is_tcp(std::size_t bus) const;

  const SoakPlan& plan_;
  const Devices& devices_;
  const Schedule& schedule_;
  Report& report_;
  WriterRules writers_;
  RuleRates rates_;
  ClientRates client_rates_;
  Meanings meanings_;
  FailsafeWatch failsafe_;
  std::map<ClientId, Session> sessions_;
  std::unordered_map<std::uint64_t, std::unique_ptr<Asked>> open_;
  std::vector<Book> books_;
  std::deque<std::unique_ptr<Flight>> flights_;
  std::deque<Done> done_;
  std::uint64_t ids_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint64_t perhaps_accepted_ = 0;
  std::uint64_t flight_count_ = 0;
  std::uint64_t before_restart_ = 0;  ///< transmissions up to this one are of another process
  std::optional<std::uint64_t> well_;
  PduBytes own_answer_;
  std::optional<Instant> stopping_;  ///< since then
  bool finished_ = false;
  Instant reloaded_ = Instant::min();
  Instant judged_ = Instant::min();  ///< a deadline was handed in last
  bool traced_ = false;
};

}  // namespace mbgate::soak
