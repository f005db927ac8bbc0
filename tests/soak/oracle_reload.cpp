// SPDX-License-Identifier: Apache-2.0
// What other settings mean for requests, devices and lines that are known already. Everything else
// is judged by the settings in force: those of the plan.
#include <algorithm>

#include "soak/heard_answers.hpp"
#include "soak/oracle.hpp"
#include "soak/withdrawals.hpp"
#include "soak/word_orders.hpp"

namespace mbgate::soak {
namespace {

void take_settings(Book& book, const gateway::BusSettings& settings, Instant now) {
  book.room = std::max(book.room, book.waiting);
  if (book.present > settings.queue) {
    book.last_full = now;  // it has become smaller than what waits
  }
  if (book.own_end > now && book.turnaround_end > book.own_end) {
    const Instant by_others = book.own_end + settings.turnaround;
    book.held_until = std::max(book.turnaround_end, by_others);
    book.turnaround_end = std::min(book.turnaround_end, by_others);
  }
  if (settings.stop_wait != book.stop_wait_before) {
    book.stop_wait_from = now;
  }
}

// Its answer has a bad CRC, and what is transmitted next to its device is the next that may be
// unanswered.
bool ends_in_damage(const SoakPlan& plan, const Book& book, const Lane& lane, const Flight& last) {
  return &lane == &book.lanes[last.address] && book.open && last.begin >= book.opened &&
         is_damaged_answer(plan, book, last);
}

}  // namespace

void Oracle::map_lanes() {
  for (Book& book : books_) {
    for (Lane& lane : book.lanes) {
      lane.device.reset();
    }
  }
  for (std::size_t index = 0; index < plan_.settings.devices.size(); ++index) {
    const drive::Device& device = plan_.settings.devices[index];
    if (!plan_.absent.devices[index]) {
      books_[static_cast<std::size_t>(device.bus)].lanes[device.address].device = index;
    }
  }
}

// On a connection only what was asked later than what was answered counts, once its response
// timeout may have ended.
bool Oracle::is_past_offline(std::size_t bus, const Lane& lane) const {
  const unsigned after = lane.device ? devices_[*lane.device].settings().timing.offline_after
                                     : bus_settings(bus).timing.offline_after;
  const auto is_over = [&](std::uint64_t number) {
    const Flight* it = flight(number);
    return it == nullptr || has_failsafe(bus) || schedule_.now() >= deadline_of(*it);
  };
  const auto unanswered =
      is_tcp(bus) ? std::ranges::count_if(lane.unheard, is_over) : std::ptrdiff_t{lane.unanswered};
  if (lane.stays_offline || after == 0 || unanswered < std::ptrdiff_t{after}) {
    return lane.stays_offline;
  }
  const Flight* last = flight(books_[bus].last_flight);
  return is_tcp(bus) || unanswered > std::ptrdiff_t{after} || last == nullptr ||
         !ends_in_damage(plan_, books_[bus], lane, *last);
}

void Oracle::note_allowed(Asked& asked) const {
  if (!asked.door->device) {
    return;
  }
  const drive::Device& device = devices_[*asked.door->device].settings();
  asked.retries = std::max(asked.retries, device.timing.retries);
  asked.stop_retries = std::max(asked.stop_retries, device.timing.stop_retries);
  asked.retry_writes = asked.retry_writes || device.timing.retry_writes;
  asked.cache = std::max(asked.cache, device.cache);
}

std::optional<drive::WordOrder> Oracle::order_of(const Door& door) const {
  return door.route ? plan_.settings.routes[*door.route].word_order : std::nullopt;
}

void Oracle::before_reload() {
  for (std::size_t bus = 0; bus < books_.size(); ++bus) {
    Book& book = books_[bus];
    cut_flying(book);
    book.stop_wait_before = bus_settings(bus).stop_wait;
    if (bus_settings(bus).merge) {
      book.last_merge = schedule_.now();
    }
    for (Lane& lane : book.lanes) {
      lane.stays_offline = is_past_offline(bus, lane);
    }
    for (Asked* stop : book.stops) {
      if (lets_writes_go(*stop)) {
        stop->waits_from = schedule_.now();  // it has waited for nothing but these
      }
    }
  }
}

void Oracle::line_given_up(std::size_t bus) {
  bus_lost(bus);
  Book& book = books_[bus];
  book.reopening = {};
  book.count = {};
  book.own_end = book.last_byte = book.turnaround_end = Instant::min();
  book.starting = true;
  for (Lane& lane : book.lanes) {
    if (is_past_offline(bus, lane)) {
      lane.last_offline = schedule_.now();
    }
    lane.unanswered = 0;
    lane.unheard.clear();
    lane.count = {};
    lane.stays_offline = false;
  }
}

void Oracle::touched(std::size_t bus) { books_[bus].touched = schedule_.now(); }

void Oracle::take_back(Asked& asked, std::size_t bus) {
  if (!asked.is_accepted || asked.refused || asked.is_stop()) {
    return;  // stops are sent: settings do not move a drive
  }
  for (Piece& piece : asked.pieces) {
    piece.taken_back = piece.taken_back || piece.bus == bus;
  }
}

void Oracle::take_back(std::size_t bus, std::uint8_t address) {
  books_[bus].lanes[address].boots_until = Instant::min();
  WordOrders(*this).forget(bus, address);
  for (Asked* asked : books_[bus].lanes[address].open) {
    take_back(*asked, bus);
  }
  for (Asked* asked : broadcasts_on(bus)) {
    take_back(*asked, bus);
  }
}

void Oracle::after_reload() {
  map_lanes();
  for (std::size_t device = 0; device < plan_.absent.devices.size(); ++device) {
    if (plan_.absent.devices[device]) {
      writers_.gone(device);
    }
  }
  failsafe_.forget_writers();
  rates_.after_reload(schedule_.now());
  client_rates_.after_reload(schedule_.now());
  meanings_.after_reload(schedule_.now());
  reloaded_ = schedule_.now();
  Withdrawals(*this).refuse_outdated();
  for (Book& book : books_) {
    for (Lane& lane : book.lanes) {
      lane.forget_silence();
    }
  }
  for (const auto& entry : open_) {
    Asked& asked = *entry.second;
    client_rates_.lifted(asked, schedule_.now());
    if (asked.is_accepted && asked.door != nullptr) {
      note_allowed(asked);
      // Its client sees other word orders by now, or its unit leads elsewhere.
      // Where it leads to no bus, that one's line is given up.
      if (asked.door->absent || asked.word_order != order_of(*asked.door)) {
        std::ranges::for_each(asked.door->buses, [&](std::size_t bus) { take_back(asked, bus); });
      }
    }
  }
  for (std::size_t bus = 0; bus < books_.size(); ++bus) {
    Book& book = books_[bus];
    take_settings(book, bus_settings(bus), schedule_.now());
    for (Asked* stop : book.stops) {
      Withdrawals(*this).take_back_for_waiting(*stop);
    }
    note_crowded(bus);
    cut_flying(book);
  }
  for (auto& [client, session] : sessions_) {
    accept_backlog(session);
  }
}

void Oracle::check_taken_back() {
  std::vector<const Asked*> forgotten;
  for (const auto& [id, asked] : open_) {
    const bool waits =
        !asked->maybe_on_wire && !asked->ordered && !asked->client_gone && asked->replies;
    if (waits && std::ranges::all_of(asked->pieces, &Piece::taken_back) && !asked->pieces.empty()) {
      forgotten.push_back(asked.get());
    }
  }
  std::ranges::sort(forgotten, {}, &Asked::id);
  for (const Asked* asked : forgotten) {
    violation("not_taken_back", name(*asked));
  }
}

// It is as old as a time before its unit came to mean something else, or may be.
bool Oracle::is_outdated(const Asked& asked) const {
  return asked.door != nullptr &&
         asked.earliest < meanings_.change_of(asked.door->listener, asked.unit).at;
}

// Where stops were taken out of what was read ahead, or something lies in a socket that is not
// read, nobody outside can tell in which order things were taken.
bool Oracle::is_within(const Door& door) const {
  const bool is_clear = std::ranges::none_of(sessions_, [&](const auto& entry) {
    const Session& session = entry.second;
    return session.listener == door.listener && (session.paused_since || !session.taken.empty());
  });
  const bool are_read = std::ranges::none_of(open_, [&](const auto& entry) {
    const Asked& asked = *entry.second;
    return asked.door == &door && !asked.is_accepted && !has_come_before(asked, schedule_.now());
  });
  return is_settled(door) || (door.device && is_clear && are_read && !is_unsure(door));
}

bool Oracle::is_settled(const Door& door) const {
  return !is_unsure(door) && std::ranges::none_of(open_, [&](const auto& entry) {
    return entry.second->door == &door && !entry.second->is_accepted;
  });
}

bool Oracle::is_unsure(const Door& door) const {
  return std::ranges::any_of(open_, [&](const auto& entry) {
    const Asked& asked = *entry.second;
    return asked.door == &door && asked.is_accepted && asked.ahead && !asked.surely_on_wire;
  });
}

bool Oracle::is_quarantined(std::size_t bus, std::uint8_t address) const {
  return std::ranges::any_of(books_[bus].lanes[address].sent, [&](std::uint64_t number) {
    const Flight* owing = flight(number);
    return owing != nullptr && !owing->paid_at && schedule_.now() < owing->quarantine_until;
  });
}

}  // namespace mbgate::soak
