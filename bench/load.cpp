// SPDX-License-Identifier: Apache-2.0
#include "load.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <span>
#include <system_error>

#include "moment.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::bench {
namespace {

constexpr std::chrono::seconds kMostPatience{5};
constexpr std::size_t kMbapSize = 7;

struct Request {
  std::uint16_t identifier;
  Moment sent;
};

struct Client {
  Stream stream{};
  unsigned bus = 0;
  unsigned address = 1;
  unsigned first = 0;
  std::uint16_t next_identifier = 0;
  std::deque<Request> outstanding{};
  std::vector<std::uint8_t> received{};
  std::vector<std::uint8_t> request{};   ///< the identifier is its first two bytes
  std::vector<std::uint8_t> expected{};  ///< the answer from its unit identifier on
};

unsigned word_at(std::span<const std::uint8_t> bytes, std::size_t place) {
  return (static_cast<unsigned>(bytes[place]) << 8U) | bytes[place + 1];
}

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

class Load {
 public:
  Load(const LoadSettings& settings, const Plant& plant, const Doors& doors)
      : settings_(settings), plant_(plant), epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
    if (doors.tls) {
      tls_.emplace(*doors.tls);
    }
    const auto& ports = doors.ports;
    for (unsigned number = 0; number < settings.clients; ++number) {
      add_client(number, ports);
    }
    for (unsigned number = 0; number < settings.idle; ++number) {
      idle_.push_back(connect(ports[number % ports.size()]));
    }
    latency_.reserve(1'000'000);
  }

  void begin() {
    for (Client& client : clients_) {
      for (unsigned count = 0; count < settings_.outstanding; ++count) {
        ask(client);
      }
    }
  }

  /// Nothing but work: what is to be said of it afterwards is figures().
  void work(Nanoseconds time) {
    counted_ = {};
    latency_.clear();
    patience_ = std::min<Nanoseconds>(kMostPatience, time / 2);
    const Moment start = Clock::now();
    const Moment end = start + time;
    for (Moment now = start; now < end; now = Clock::now()) {
      std::array<epoll_event, 256> events{};
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - now);
      const int count =
          ::epoll_wait(epoll_.get(), events.data(), events.size(), static_cast<int>(left.count()));
      for (int event = 0; event < count; ++event) {
        receive(clients_[events[static_cast<std::size_t>(event)].data.u32]);
      }
    }
    counted_.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  }

  [[nodiscard]] LoadFigures figures() {
    LoadFigures figures = counted_;
    const Moment now = Clock::now();
    for (const Client& client : clients_) {
      figures.unanswered += static_cast<std::uint64_t>(
          std::count_if(client.outstanding.begin(), client.outstanding.end(),
                        [&](const Request& request) { return now - request.sent > patience_; }));
      figures.lost += client.stream.is_open() ? 0 : 1;
    }
    figures.lost +=
        static_cast<std::uint64_t>(std::count_if(idle_.begin(), idle_.end(), [](Stream& stream) {
          std::uint8_t byte = 0;
          return stream.receive({&byte, 1}) == 0;
        }));
    figures.latency = latency_.spread();
    return figures;
  }

 private:
  [[nodiscard]] Stream connect(std::uint16_t port) const {
    return {connect_to(port), tls_ ? &*tls_ : nullptr};
  }

  void add_client(unsigned number, const std::vector<std::uint16_t>& ports) {
    Client client;
    client.bus = number % plant_.buses;
    client.address = 1 + number / plant_.buses % plant_.devices;
    client.first = settings_.same ? 0 : number % 500 * 130;
    client.stream = connect(ports[client.bus]);
    const Frame request = make_request(client.address, client.first, plant_.registers);
    const Frame response = answer(client.bus, request);
    client.request = {0, 0, 0, 0, 0, 6};
    client.request.insert(client.request.end(), request.begin(), request.end() - 2);
    client.expected.assign(response.begin(), response.end() - 2);
    epoll_event event{EPOLLIN, {}};
    event.data.u32 = number;
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, client.stream.descriptor(), &event);
    clients_.push_back(std::move(client));
  }

  void ask(Client& client) {
    const std::uint16_t identifier = client.next_identifier++;
    client.request[0] = static_cast<std::uint8_t>(identifier >> 8U);
    client.request[1] = static_cast<std::uint8_t>(identifier & 0xFFU);
    client.outstanding.push_back({identifier, Clock::now()});
    if (!client.stream.send(client.request)) {
      lose(client);
    }
  }

  /// With TLS, bytes may wait in the session where the socket has none any more.
  void receive(Client& client) {
    do {
      receive_part(client);
    } while (tls_ && client.stream.has_pending());
  }

  void receive_part(Client& client) {
    const auto count = client.stream.receive(part_);
    if (count < 0) {
      return;
    }
    if (count == 0) {
      lose(client);
      return;
    }
    client.received.insert(client.received.end(), part_.begin(), part_.begin() + count);
    std::size_t used = 0;
    while (client.stream.is_open() && client.received.size() - used >= kMbapSize) {
      const auto rest = std::span(client.received).subspan(used);
      const std::size_t size = 6 + word_at(rest, 4);
      if (rest.size() < size) {
        break;
      }
      take(client, rest.first(size));
      used += size;
    }
    client.received.erase(client.received.begin(),
                          client.received.begin() + static_cast<std::ptrdiff_t>(used));
  }

  /// Answers may come in another order than the requests.
  void take(Client& client, std::span<const std::uint8_t> adu) {
    const unsigned identifier = word_at(adu, 0);
    const auto request = std::ranges::find_if(client.outstanding, [&](const Request& candidate) {
      return candidate.identifier == identifier;
    });
    if (request == client.outstanding.end() || word_at(adu, 2) != 0) {
      ++counted_.wrong;
      return;
    }
    const auto body = adu.subspan(6);
    if (body.size() == 3 && body[0] == client.expected[0] &&
        body[1] == (client.expected[1] | 0x80U)) {
      ++counted_.exceptions;
    } else if (std::ranges::equal(body, client.expected)) {
      ++counted_.answers;
      const Nanoseconds latency = Clock::now() - request->sent;
      latency_.add(latency);
      counted_.unanswered += latency > patience_ ? 1 : 0;
    } else {
      ++counted_.wrong;
    }
    client.outstanding.erase(request);
    ask(client);
  }

  /// It is counted at the end.
  static void lose(Client& client) {
    client.stream.close();
    client.outstanding.clear();
  }

  LoadSettings settings_;
  Plant plant_;
  sys::UniqueFd epoll_;
  std::vector<Client> clients_;
  std::vector<Stream> idle_;
  std::optional<TlsClients> tls_;
  std::array<std::uint8_t, 8192> part_{};
  LoadFigures counted_;
  Samples latency_;
  Nanoseconds patience_{0};
};

}  // namespace

sys::UniqueFd connect_to(std::uint16_t port) {
  sys::UniqueFd socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int on = 1;
  if (socket.get() < 0 ||
      ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on) != 0 ||
      // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the way of the socket
      // interface
      ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    fail("connect");
  }
  return socket;
}

void run_load(const LoadSettings& settings, const Plant& plant, const Doors& doors,
              const Times& times, int output) {
  Load load(settings, plant, doors);
  load.begin();
  load.work(times.warm_up);
  const char began = 'B';
  if (::write(output, &began, 1) != 1) {
    fail("write");
  }
  load.work(times.measured);
  const LoadFigures figures = load.figures();
  if (::write(output, &figures, sizeof figures) != sizeof figures) {
    fail("write");
  }
}

void run_flood(unsigned connections, std::uint16_t port) {
  // It stands for another computer, and so takes only what processors have left.
  ::setpriority(PRIO_PROCESS, 0, 19);
  std::vector<sys::UniqueFd> sockets(connections);
  std::array<std::uint8_t, 4096> garbage{};
  std::uint32_t state = 1;
  for (auto& byte : garbage) {
    state = state * 1664525U + 1013904223U;
    byte = static_cast<std::uint8_t>(state >> 24U);
  }
  for (;;) {
    for (auto& socket : sockets) {
      if (socket.get() < 0) {
        socket = connect_to(port);
      }
      if (::send(socket.get(), garbage.data(), garbage.size(), MSG_NOSIGNAL | MSG_DONTWAIT) < 0 &&
          errno != EAGAIN) {
        socket.reset(-1);
      }
    }
  }
}

}  // namespace mbgate::bench
