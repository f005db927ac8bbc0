// SPDX-License-Identifier: Apache-2.0
// A client as a person with bad manners would write one: bursts, pieces, stalls, sudden ends. It
// keeps what it has written but the gateway does not read at present, as a socket does.
#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "soak/asking.hpp"
#include "soak/from_world.hpp"
#include "soak/oracle.hpp"
#include "support/gateway_harness.hpp"

namespace mbgate::soak {

inline constexpr std::size_t kNoListener = ~std::size_t{0};

/// Where somebody makes room for another at this instant.
struct Crowded {
  std::size_t listener = kNoListener;
  std::optional<unsigned> host{};  ///< only those of this one make room
};

class Client {
 public:
  struct Tools {
    test::GatewayHarness& harness;
    Driver& driver;
    Oracle& oracle;
    Schedule& schedule;
    Random& random;
    Report& report;
    Asking& asking;
    std::function<void()> drain;  ///< does what the gateway has asked for
    std::function<ClientId()> new_number;
    /// As the gateway counts them now; none if nobody listens there.
    std::function<std::optional<gateway::ListenerId>(std::size_t)> listener;
    const SoakPlan& plan;
    const gateway::Settings& settings;  ///< of the plan
    std::deque<Client>& all;
    Crowded& full;
    bool& is_stopping;  ///< the gateway was told to stop
  };
  Client(const Manners& manners, Tools& tools) : manners_(manners), tools_(tools) {}

  /// Connects some time, and behaves as it is used to until it is told to stop.
  void begin();
  void end_asking() { asking_ = false; }
  /// It goes for good.
  void leave();
  /// Takes all answers from now on.
  void end_stall();

  [[nodiscard]] ClientId number() const { return number_; }
  /// As the process knows it.
  [[nodiscard]] bool is_connected() const { return connected_; }

  // What the gateway asks for.
  void take(Bytes adu);
  void pause() {
    paused_ = true;
    tools_.oracle.paused(number_);
  }
  void resume();
  /// The process looks whether there is anything in its socket.
  void be_read();
  void closed_by_gateway();
  /// The process is no more, and asks for nothing.
  void be_cut_off();
  /// Other settings: the gateway will close it.
  void give_up();
  [[nodiscard]] bool shares_listener(const Client& other) const {
    return manners_.listener == other.manners_.listener;
  }
  /// Its framing is lost behind a request that waited for its turn. That may have come by now, and
  /// nobody has told the gateway.
  [[nodiscard]] bool may_be_found_lost() const;
  /// Is there a listener for it, which lets it in?
  [[nodiscard]] bool is_welcome() const;

  /// Connects for good if it is not connected; puts a request into the socket.
  void connect();
  std::uint64_t write(Asked asked);

 private:
  // client_ends.cpp
  void be_patient();
  void write_before_the_start();
  void hang();
  void lose_framing();
  void be_closed_after(Duration time, const char* kind);
  [[nodiscard]] bool may_be_closed() const;
  [[nodiscard]] bool may_be_displaced() const;
  [[nodiscard]] Crowded crowd() const;
  [[nodiscard]] bool shares_host(const Client& other) const {
    return shares_listener(other) && manners_.host == other.manners_.host;
  }
  [[nodiscard]] bool is_idle() const;
  [[nodiscard]] bool is_kept() const;
  void act();
  void ask_some();
  void put_foreign();
  // client_tails.cpp
  [[nodiscard]] bool keeps_tails() const { return straddles_ && asking_ && !half_closed_; }
  void become_straddler();
  void keep_tail(std::size_t request);
  void push(std::size_t bytes);
  void become_ready();
  void feed();
  void look_at_socket();
  void read_some();
  void vanish();
  void be_gone();
  void half_close();
  void reconnect_later();
  void plan_next();
  void confirm();

  Manners manners_;
  Tools& tools_;
  ClientId number_{};
  bool asking_ = true;
  bool connected_ = false;
  bool vanished_ = false;  ///< the process does not know it yet
  bool is_ready_ = false;  ///< the process will look at its socket
  bool paused_ = false;
  bool stalled_ = false;
  bool half_closed_ = false;
  bool fin_read_ = false;
  bool is_silent_ = false;  ///< it asks for nothing any more
  bool framing_lost_ = false;
  bool straddles_ = false;              ///< what it writes always ends within a request
  bool is_connecting_ = false;          ///< at this instant
  bool may_be_refused_ = false;         ///< then: its host connects too often
  std::optional<Instant> hangs_since_;  ///< the gateway may have the beginning of a request
  Duration frame_timeout_{0};           ///< as it was then
  Instant active_ = Instant::min();     ///< when the gateway read something or saw it taken
  Instant looked_ = Instant::min();     ///< when the gateway looked into its socket
  std::uint64_t life_ = 0;              ///< of the connection; events of an earlier one are void
  std::uint16_t transactions_ = 0;
  std::size_t unconfirmed_ = 0;
  std::deque<std::uint8_t> unwritten_;  ///< the client still has it
  std::deque<std::uint8_t> socket_;     ///< written, not read
  struct Mark {
    std::uint64_t begin;  ///< of the request, in bytes since the connection began
    std::uint64_t end;
    std::uint64_t id;
    bool has_begun = false;  ///< its first byte was read
  };
  std::deque<Mark> marks_;
  std::uint64_t made_ = 0;
  std::uint64_t read_ = 0;
};

}  // namespace mbgate::soak
