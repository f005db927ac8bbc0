// SPDX-License-Identifier: Apache-2.0
#include "fuzz/driver.hpp"

#include "gateway/limits.hpp"

namespace mbgate::fuzz {
namespace {

using namespace std::chrono_literals;

/// Far above what one input may set off: the end of everything that waits.
constexpr int kMostActions = 20'000;
/// Everything that can wait at one instant: each line, each client.
constexpr int kMostTurns = 200;
/// Longer than the longest deadline, with all that may stand before it on a line.
constexpr bus::Duration kPatience = 60s;

}  // namespace

Driver::Driver(gateway::Settings settings)
    : harness_(std::move(settings), bus::Instant{1s}), lines_(harness_.settings().buses.size()) {
  drain();
}

void Driver::connect(std::uint32_t listener, std::uint8_t host, bool through_a_start) {
  routing::ClientAddress::Octets octets{};
  octets[10] = octets[11] = 0xFF;
  octets[15] = host;
  const ClientId id{next_client_++};
  clients_.try_emplace(id);
  gateway::ClientInfo info{gateway::ListenerId{listener}, routing::ClientAddress(octets)};
  if (through_a_start) {
    info.waits_since = bus::Instant::min();
  }
  feed(gateway::ClientConnected{id, info});
}

void Driver::client_bytes(std::size_t index, modbus::Bytes bytes) {
  Client* const client = client_at(index);
  if (client == nullptr || client->ended || bytes.empty()) {
    return;
  }
  if (client->paused || !client->held.empty()) {
    client->held.emplace_back(bytes.begin(), bytes.end());
    return;
  }
  read(ClientId{index}, *client, bytes);
  drain();
}

void Driver::read(ClientId id, Client& client, modbus::Bytes bytes) {
  require(bytes.size() <= gateway::kClientReadSize, "pieces are as the machine wants them");
  client.stream.insert(client.stream.end(), bytes.begin(), bytes.end());
  expect_answers(client);
  std::size_t unread = 0;
  for (const auto& piece : client.held) {
    unread += piece.size();
  }
  harness_.handle(gateway::ClientBytes{id, bytes, unread});
}

/// Every whole request of the stream is due one answer.
void Driver::expect_answers(Client& client) {
  for (;;) {
    const modbus::MbapScan scan = modbus::scan_mbap(client.stream);
    std::size_t size = 0;
    if (const auto* frame = std::get_if<modbus::MbapFrame>(&scan)) {
      const auto& [header, pdu] = frame->adu;
      client.due.emplace(header.transaction, Asked{header.unit, pdu.function()});
      size = frame->size;
    } else if (const auto* foreign = std::get_if<modbus::MbapForeign>(&scan)) {
      size = foreign->size;
    } else {
      return;
    }
    client.stream.erase(client.stream.begin(),
                        client.stream.begin() + static_cast<std::ptrdiff_t>(size));
  }
}

void Driver::half_close(std::size_t index) {
  Client* const client = client_at(index);
  if (client != nullptr && !client->ended) {
    client->ended = true;  // noticed at once; reading may come to it later
    feed(gateway::ClientHalfClosed{ClientId{index}});
  }
}

void Driver::disconnect(std::size_t index) {
  if (Client* const client = client_at(index)) {
    client->open = false;
    feed(gateway::ClientDisconnected{ClientId{index}});
  }
}

void Driver::confirm(std::size_t index) {
  Client* const client = client_at(index);
  if (client != nullptr && client->unconfirmed > 0) {
    --client->unconfirmed;
    feed(gateway::ClientSent{ClientId{index}});
  }
}

void Driver::line_bytes(std::size_t bus, modbus::Bytes bytes) {
  if (lines_[bus].open && !bytes.empty()) {
    feed(gateway::LineBytes{BusId{static_cast<std::uint32_t>(bus)}, bytes});
  }
}

void Driver::lose(std::size_t bus) {
  if (lines_[bus].open) {
    lines_[bus].open = false;
    feed(gateway::LineLost{BusId{static_cast<std::uint32_t>(bus)}});
  }
}

void Driver::set_slow(std::size_t bus, bool slow) {
  lines_[bus].slow = slow;
  drain();
}

void Driver::reload(gateway::Settings settings, bool is_same) {
  if (is_same) {
    advance({});  // what is due now is not set off by the settings
  }
  const auto before = harness_.settings().buses;
  harness_.handle(gateway::SettingsChanged{&settings});
  const auto& after = harness_.settings().buses;
  for (std::size_t bus = 0; bus < before.size(); ++bus) {
    const bool changed = after[bus].is_gone || after[bus].line != before[bus].line;
    lines_[bus].outdated = !before[bus].is_gone && changed;
  }
  lines_.resize(after.size());
  undisturbed_ = is_same;
  drain();
  require(std::ranges::none_of(lines_, &Line::outdated), "a line that has changed is closed");
}

void Driver::shutdown() {
  stopping_ = true;
  feed(gateway::ShutdownAsked{});
}

void Driver::advance(bus::Duration duration) {
  bus::Instant place = harness_.now();
  int turns = 0;
  harness_.advance(place + duration, [&] {
    turns = harness_.now() > place ? 1 : turns + 1;
    place = harness_.now();
    require(turns <= kMostTurns, "handling a deadline gets on");
    drain();
  });
}

void Driver::feed(const gateway::Input& input) {
  harness_.handle(input);
  drain();
}

void Driver::finish() {
  for (Line& line : lines_) {
    line.slow = false;
  }
  drain();
  const bus::Instant end = harness_.now() + kPatience;
  while (harness_.now() < end) {
    for (auto& [id, client] : clients_) {
      while (client.open && client.unconfirmed > 0) {
        confirm(static_cast<std::size_t>(id));
      }
    }
    advance(1s);
  }
  for (const auto& [id, client] : clients_) {
    if (client.open) {
      require(!client.paused && client.held.empty(), "a client that is answered is read again");
      require(client.due.empty(), "every request is answered");
    }
  }
  require(finished_ == stopping_, "a gateway that stops has finished");
}

void Driver::drain() {
  int actions = 0;
  do {
    harness_.drain([&](const gateway::Action& action) {
      require(++actions <= kMostActions, "one input does not set off actions without end");
      require(!undisturbed_, "the same settings again change nothing");
      std::visit([this](const auto& wanted) { take(wanted); }, action);
    });
    undisturbed_ = false;
  } while (serve_lines() || serve_clients());
  const auto next = harness_.next_wake();
  require(!next || next->at < harness_.now() + 1h, "no deadline is further away than any timeout");
}

Driver::Line& Driver::line(BusId bus) {
  require(static_cast<std::size_t>(bus) < lines_.size(), "a line that is meant is there");
  return lines_[static_cast<std::size_t>(bus)];
}

/// Opens the lines that are asked for; true if there were any.
bool Driver::serve_lines() {
  bool any = false;
  for (std::size_t index = 0; index < lines_.size(); ++index) {
    Line& line = lines_[index];
    if (!line.slow && std::exchange(line.asked, false) && !line.open) {
      const BusId bus{static_cast<std::uint32_t>(index)};
      any = true;
      line.open = line.present;
      line.present ? harness_.handle(gateway::LineOpened{bus})
                   : harness_.handle(gateway::LineLost{bus});
    }
  }
  return any;
}

/// Reads what lies in the sockets of those who may be read again; true if there were any.
bool Driver::serve_clients() {
  const auto resumed = std::exchange(resumed_, {});
  for (const ClientId id : resumed) {
    Client* const client = client_at(static_cast<std::size_t>(id));
    if (client == nullptr || client->paused) {
      continue;
    }
    if (client->held.empty()) {
      client->ended ? harness_.handle(gateway::ClientHalfClosed{id})
                    : harness_.handle(gateway::ClientBytes{id, {}, 0});
      continue;
    }
    const auto bytes = std::move(client->held.front());
    client->held.pop_front();
    resumed_.push_back(id);
    read(id, *client, bytes);
  }
  return !resumed.empty();
}

}  // namespace mbgate::fuzz
