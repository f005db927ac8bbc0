// SPDX-License-Identifier: Apache-2.0
// A client as a person with bad manners would write one: bursts, pieces, stalls, sudden ends, a
// timeout of its own. What it has written and the process has not read lies in its socket.
#pragma once

#include <functional>

#include "support/gateway_harness.hpp"
#include "world/asking.hpp"
#include "world/report.hpp"

namespace mbgate::world {

/// What a client does with the process, and who is told of it.
struct ClientTools {
  const Plan& plan;
  Schedule& schedule;
  Random& random;
  Driver& driver;
  Ledger& ledger;
  Report& report;
  Asking& asking;
  std::function<void(const gateway::Input&)> hand_in;  ///< and does what the gateway asks for
  std::function<void(Id)> asked;                       ///< it was written
  std::function<void(Id)> given;                       ///< the gateway has all of it
  std::function<void(Id)> answered;
  std::function<void(Id)> gone;  ///< a connection
};

class Client {
 public:
  Client(const Manners& manners, ClientTools& tools) : manners_(manners), tools_(tools) {}

  void begin();
  void end_asking() { asks_ = false; }
  [[nodiscard]] bool is_connected() const { return connected_; }
  [[nodiscard]] gateway::ClientId number() const {
    return gateway::ClientId{std::uint64_t{connection_} + 1};
  }
  void connect();
  /// Puts a request into its socket.
  Id write(Intent intent);
  void leave();
  /// It takes all answers from now on.
  void end_stall();
  /// The process is no more, or has closed it.
  void be_cut_off();
  /// The process looks into its socket after it has not run for a while.
  void be_read();

  // What the gateway asks for.
  void take(Bytes adu);
  void pause() { paused_ = true; }
  void resume();

 private:
  struct Mark {
    std::size_t end;
    Id asked;
  };
  void plan_next();
  void act();
  void ask_some();
  [[nodiscard]] bool is_waiting_enough() const;
  void be_patient(Id asked);
  void lose_patience(Id asked);
  /// No answer to it may come any more.
  void forget(Id asked);
  void forget_before(Id asked);
  void push(std::size_t bytes);
  void become_ready();
  void feed();
  void read_some();
  void look();
  void confirm();
  void vanish();
  void half_close();
  void be_gone();
  void come_after(Duration delay);
  [[nodiscard]] const gateway::ListenerSettings& listener() const {
    return tools_.plan.settings.listeners[manners_.listener];
  }
  [[nodiscard]] std::function<void()> while_alive(std::function<void()> what);

  Manners manners_;
  ClientTools& tools_;
  Id connection_ = kNone;
  std::uint64_t life_ = 0;
  bool asks_ = true;
  bool connected_ = false;
  bool leaving_ = false;
  bool is_ready_ = false;
  bool paused_ = false;
  bool stalled_ = false;
  bool half_closed_ = false;
  bool fin_read_ = false;
  Octets unwritten_;
  Octets socket_;
  std::size_t made_ = 0;  ///< bytes of its requests, since it was connected
  std::size_t pushed_ = 0;
  std::size_t read_ = 0;
  std::deque<Mark> marks_;
  std::unordered_map<std::uint16_t, Id> open_;  ///< by transaction identifier
  unsigned unconfirmed_ = 0;
  std::uint16_t transactions_ = 0;
};

}  // namespace mbgate::world
