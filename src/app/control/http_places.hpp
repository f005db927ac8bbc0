// SPDX-License-Identifier: Apache-2.0
// Limits the connections to the HTTP interface over one kind of socket. A new connection is
// accepted unless every other one is in the middle of a command: the client with the most
// connections loses one, first the one for whose client the interface has waited longest. So a
// client that opens connections without end only closes its own. Pure but for the clock; it knows
// nothing of sockets.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace mbgate::app {

class HttpPlaces {
 public:
  using Close = std::function<void()>;

  /// What one connection has, as long as it is held. It knows what its connection does.
  class Place {
   public:
    Place(std::string client, Close close);
    /// For the client from now on: for its request, or until it takes the answer.
    void wait() { enter(state_ == State::new_here ? state_ : State::waits); }
    /// From now on; a command, which changes something, is not disturbed.
    void answer(bool is_command) { enter(is_command ? State::commanded : State::answered); }

   private:
    friend class HttpPlaces;
    /// Those that go first come first. Who has just come may be about to give a command.
    enum class State : std::uint8_t { waits, answered, new_here, commanded };
    void enter(State state);
    [[nodiscard]] State state_at(std::chrono::steady_clock::time_point now) const;

    std::string client_;
    Close close_;
    State state_ = State::new_here;
    std::chrono::steady_clock::time_point since_;
  };

  /// `most_of_one`: of one client.
  HttpPlaces(std::size_t most, std::size_t most_of_one) : most_(most), most_of_one_(most_of_one) {}

  /// `client`: what places are counted by. `close` ends the connection, if another is to have its
  /// place. Nothing: no place can be had.
  std::shared_ptr<Place> take(const std::string& client, Close close);

 private:
  using Held = std::vector<std::shared_ptr<Place>>;

  /// Removes those whose connections have ended.
  Held held();
  /// Who gives a place up for that client; nothing: nobody.
  [[nodiscard]] std::shared_ptr<Place> displaced_for(const std::string& client,
                                                     const Held& held) const;

  std::size_t most_;
  std::size_t most_of_one_;
  std::vector<std::weak_ptr<Place>> places_;
};

}  // namespace mbgate::app
