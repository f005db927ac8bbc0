// SPDX-License-Identifier: Apache-2.0
// A small world: the product's own gateway, a line with two devices, two clients, and the process
// around it, in virtual time. At each moment it says what may happen next; whoever explores it
// takes one of these. Time stands still but for `pass`, and goes on only to instants at the edges
// of the rules: just before, at, and just after each.
#pragma once

#include "explore/oracle.hpp"
#include "support/gateway_harness.hpp"

namespace mbgate::explore {

/// How much may happen in all.
struct Bounds {
  unsigned requests = 0;
  unsigned faults = 0;
  unsigned delays = 0;
  bool forms = false;  ///< answers come damaged, twice and in halves too, not only late or never
  /// Answers are followed by second ones, and devices become slow, but work in order.
  bool drives = false;
  /// 3: just before, at and just after each edge; 2: not after it; 1: at it only.
  unsigned instants = 3;
};

/// What may still go wrong. The more may, the more may happen; and what is asked for is the
/// stricter the less went wrong before.
struct Slack {
  unsigned faults = 0;
  unsigned delays = 0;
  bool is_undisturbed = false;
};

enum class Act : std::uint8_t {
  pass,     ///< the deadline that is due is handed in, or time goes on
  ask,      ///< a client asks; where the driver is awake, that is handed in at once
  answer,   ///< an answer reaches the kernel; where the driver is awake, it is handed in at once
  damaged,  ///< the same, with a wrong CRC
  twice,    ///< the same, followed by its copy without a silence
  first,    ///< an answer in time; within a response timeout it comes once more, or never does
  slow,     ///< from now on a device takes longer than the response timeout for each request
  half,     ///< the first half of an answer is handed in
  rest,     ///< the other half
  leave,    ///< an answer reaches the kernel, and clients are served first
  sleep,    ///< a deadline is due, and the driver does nothing for a while
  wake,
  read,  ///< what the kernel has of the line is handed in
  take   ///< what the kernel has of a client is handed in
};

struct Choice {
  Act act = Act::pass;
  std::uint16_t which = 0;  ///< transmission, client or device
  Ask ask{};
};

class World {
 public:
  World(const Plant& plant, const Bounds& bounds, bool is_reported = false);

  /// What may happen now, in an order that depends on the state alone; nothing once something is
  /// violated.
  [[nodiscard]] std::vector<Choice> choices();
  void take(const Choice& choice);

  [[nodiscard]] const std::string& violation() const { return oracle_.violation(); }
  [[nodiscard]] unsigned learning() const { return oracle_.learning(); }
  /// More went wrong than may: this is not to be explored.
  [[nodiscard]] bool is_beyond() const { return is_beyond_; }
  /// Two worlds with the same digest and slack have the same future.
  [[nodiscard]] Digest digest();
  [[nodiscard]] Slack slack() const {
    return {left_.faults, left_.delays, !oracle_.is_disturbed()};
  }
  /// What was seen from outside since the last choice: frames and answers, less the numbers that
  /// only tell transmissions apart.
  [[nodiscard]] Digest seen() { return seen_.digest(); }

 private:
  struct Piece {
    std::uint16_t serial;
    Act form;
  };

  // world_choices.cpp
  void add_asks(std::vector<Choice>& choices) const;
  void add_answers(std::vector<Choice>& choices) const;
  void add_bunch(std::vector<Choice>& choices);
  void add_faults(std::vector<Choice>& choices, const Flight& flight) const;
  [[nodiscard]] Instant opens(const Flight& flight) const;
  [[nodiscard]] Instant closes(const Flight& flight) const;
  [[nodiscard]] bool is_slow(const Flight& flight) const { return slow_[flight.device]; }
  [[nodiscard]] bool may_come(const Flight& flight) const;
  [[nodiscard]] unsigned cost_of(const Flight& flight) const;
  [[nodiscard]] bool may_pass() const;
  [[nodiscard]] bool is_due() const;
  [[nodiscard]] std::optional<Instant> next_instant() const;
  [[nodiscard]] bool is_missed(const Flight& flight, Instant until) const;
  [[nodiscard]] unsigned missed(Instant until) const;
  [[nodiscard]] const Flight* half_heard() const;

  [[nodiscard]] Instant now() const { return harness_.now(); }
  void pass();
  void miss(Instant until);
  void lose(Flight& flight);
  void go_on(Instant to);
  void ask(const Ask& ask);
  void take_client(std::uint8_t client);
  void arrive(std::uint16_t serial, Act form);
  void hand_in();
  void settle();
  void handle(const gateway::Action& action);
  void tell(const std::string& text) const;

  const Plant& plant_;
  Bounds bounds_;
  Bounds left_;
  bool is_told_;
  test::GatewayHarness harness_;
  Instant begun_;
  Oracle oracle_;
  std::vector<Octets> sockets_{kClients};  ///< what the kernel has of clients,
  Octets kernel_;                          ///< and of the line
  std::vector<Piece> pieces_;              ///< that these are
  bool is_beyond_ = false;
  bool is_left_ = false;  ///< nobody has asked since these came
  std::optional<Instant> asleep_since_;
  std::uint8_t clients_ = 0;  ///< that have asked,
  std::uint8_t devices_ = 0;  ///< and that were asked,
  bool has_read_ = false;     ///< what
  std::array<bool, kDevices> slow_{};
  std::vector<gateway::ClientId> written_;
  StateHash seen_;
};

std::string to_text(const Choice& choice);

}  // namespace mbgate::explore
