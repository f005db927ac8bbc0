// SPDX-License-Identifier: Apache-2.0
#include "soak/word_orders.hpp"

#include "soak/oracle.hpp"

namespace mbgate::soak {

// Nothing was heard of it in all of its time.
void WordOrders::after_wait(std::size_t bus) const {
  Book& book = oracle_.books_[bus];
  const Flight* last = oracle_.flight(book.last_flight);
  const bool is_silent = last != nullptr && !oracle_.is_tcp(bus) && !last->is_broadcast &&
                         last->begin >= book.opened && book.came == 0 &&
                         oracle_.schedule_.now() >= last->due && oracle_.reloaded_ < last->begin;
  if (is_silent) {
    book.lanes[last->address].knows_order = false;
  }
}

// The form of a broadcast that the AiC hears has a function of its own, and leads to no order.
void WordOrders::note_told(const Flight& flight) const {
  const auto fields = spec::fields_of(flight.pdu);
  if (!fields || !fields->writes || fields->writes->table != Table::holding_registers ||
      fields->writes->first > kCommunicationRegister ||
      fields->writes->first + fields->writes->count <= kCommunicationRegister) {
    return;
  }
  auto& lanes = oracle_.books_[flight.bus].lanes;
  for (std::size_t address = 0; address < lanes.size(); ++address) {
    if (flight.is_broadcast || address == flight.address) {
      lanes.at(address).knows_order = false;
    }
  }
}

void WordOrders::forget_line(std::size_t bus) const {
  for (Lane& lane : oracle_.books_[bus].lanes) {
    lane.knows_order = false;
  }
}

// An answer that is still to come may say what is asked for now too.
void WordOrders::forget(std::size_t bus, std::uint8_t address) const {
  const Book& book = oracle_.books_[bus];
  const Flight* last = oracle_.flight(book.last_flight);
  if (!oracle_.is_tcp(bus) && (last == nullptr || !last->asks_order)) {
    oracle_.books_[bus].lanes[address].knows_order = false;
  }
}

}  // namespace mbgate::soak
