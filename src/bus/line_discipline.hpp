// SPDX-License-Identifier: Apache-2.0
// The line of a bus, of whichever discipline. SerialDiscipline and TcpDiscipline say what each
// function promises.
#pragma once

#include <algorithm>
#include <utility>
#include <variant>

#include "bus/serial/serial_discipline.hpp"
#include "bus/tcp/tcp_discipline.hpp"

namespace mbgate::bus {

class LineDiscipline {
 public:
  /// `settings` must outlive this object and always be those in force.
  LineDiscipline(const BusSettings& settings, BusCounters& counters)
      : line_(settings.line.framing == Framing::tcp
                  ? Variant(std::in_place_type<TcpDiscipline>, settings, counters, use_)
                  : Variant(std::in_place_type<SerialDiscipline>, settings, counters)) {}
  LineDiscipline(const LineDiscipline&) = delete;  // its parts refer to each other
  LineDiscipline& operator=(const LineDiscipline&) = delete;

  void open(Instant now, LineKind kind, Instant listen_until) {
    use_.open();
    std::visit([&](auto& line) { line.open(now, kind, listen_until); }, line_);
  }
  /// The turnaround of a broadcast, or a frame, may be running on the line of before.
  void take_over(const LineDiscipline& before) { not_before_ = before.possible_at(); }
  [[nodiscard]] Instant ready_at(Duration gap) const {
    return when([gap](const auto& it) { return it.ready_at(gap); });
  }
  [[nodiscard]] Instant ready_for_stop_at() const {
    return when([](const auto& it) { return it.ready_for_stop_at(); });
  }
  [[nodiscard]] Instant possible_at() const {
    return when([](const auto& it) { return it.possible_at(); });
  }
  /// Nothing on a connection, where no silence is asked for.
  [[nodiscard]] const LineSilence* silence() const {
    return serial() == nullptr ? nullptr : &serial()->silence();
  }
  FrameBytes begin(Transaction& transaction, const drive::DeviceTiming& timing, OwedAnswers owed,
                   Instant now) {
    use_.note_asked(now);
    return std::visit(
        [&](auto& line) { return line.begin(transaction, timing, std::move(owed), now); }, line_);
  }
  void limit_wait(const Transaction& transaction, Duration longest) {
    std::visit([&](auto& line) { line.limit_wait(transaction, longest); }, line_);
  }
  [[nodiscard]] std::optional<Instant> response_due() const {
    return std::visit([](const auto& line) { return std::optional(line.response_due()); }, line_);
  }
  /// Other times on the same line.
  void update() {
    if (SerialDiscipline* line = serial()) {
      line->update();
    }
  }
  std::optional<UnsolicitedFrame> take_unsolicited() {
    return std::visit([](auto& line) { return line.take_unsolicited(); }, line_);
  }
  void abort() {
    std::visit([](auto& line) { line.abort(); }, line_);
  }
  /// Nothing if it is a connection.
  SerialDiscipline* serial() { return std::get_if<SerialDiscipline>(&line_); }
  [[nodiscard]] const SerialDiscipline* serial() const {
    return std::get_if<SerialDiscipline>(&line_);
  }
  void handle_bytes(modbus::Bytes bytes, Instant now) {
    std::visit([&](auto& line) { line.handle_bytes(bytes, now); }, line_);
  }
  void handle_deadline(Instant now) {
    std::visit([&](auto& line) { line.handle_deadline(now); }, line_);
  }
  [[nodiscard]] std::optional<Instant> next_deadline() const {
    return std::visit([](const auto& line) { return line.next_deadline(); }, line_);
  }
  /// How the open connection, or a serial line behind `tcp://`, was used.
  [[nodiscard]] const ConnectionUse& use() const { return use_; }
  void note_closed(Instant now) { use_.note_closed(now); }
  std::optional<LineEnd> take_end(Instant now) {
    const auto end = std::visit([](auto& line) { return line.take_end(); }, line_);
    if (end && end->how == LineEnd::How::response && serial() != nullptr) {
      use_.note_answer(now);
    }
    return end;
  }
  std::optional<LineFault> take_fault() {
    return std::visit([](auto& line) { return line.take_fault(); }, line_);
  }
  /// Never on a connection.
  [[nodiscard]] NoticedEcho noticed_echo() const {
    return serial() == nullptr ? NoticedEcho::none : serial()->noticed_echo();
  }
  [[nodiscard]] LineState state(Instant now) const {
    return std::visit([&](const auto& line) { return line.state(now); }, line_);
  }

 private:
  using Variant = std::variant<SerialDiscipline, TcpDiscipline>;
  /// When something may be sent: the silence of a serial line says that, or a connection itself.
  template <typename Ask>
  [[nodiscard]] Instant when(Ask ask) const {
    return std::max(not_before_,
                    silence() == nullptr ? ask(std::get<TcpDiscipline>(line_)) : ask(*silence()));
  }

  ConnectionUse use_;  // of a serial line: of interest behind `tcp://`
  Variant line_;
  Instant not_before_ = Instant::min();
};

}  // namespace mbgate::bus
