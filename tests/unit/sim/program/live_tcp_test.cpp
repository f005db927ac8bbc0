// SPDX-License-Identifier: Apache-2.0
// The shell's parts with real sockets on the loopback, but with instants that the test hands in.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>

#include "sim/program/live_bus.hpp"
#include "unit/sim/wire/wire_rig.hpp"

namespace mbgate::test {
namespace {

constexpr auto kTcpReadStatus = "00 07 00 00 00 06 FF 03 00 01 00 01";
constexpr auto kTcpStatus = "00 07 00 00 00 05 FF 03 02 00 09";

class Client {
 public:
  explicit Client(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ =
        ::connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  [[nodiscard]] bool connected() const { return connected_; }
  void send(std::string_view text) const {
    const auto bytes = unhex(text);
    ASSERT_EQ(::send(socket_.get(), bytes.data(), bytes.size(), 0),
              static_cast<ssize_t>(bytes.size()));
  }
  /// What comes next, "closed" if the other side has gone; only a broken test waits long.
  [[nodiscard]] std::string receive() const {
    pollfd waiting{socket_.get(), POLLIN, 0};
    std::array<std::uint8_t, 512> bytes{};
    if (::poll(&waiting, 1, 10'000) != 1) {
      return "nothing";
    }
    const ssize_t size = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
    return size <= 0 ? "closed" : hex({bytes.data(), static_cast<std::size_t>(size)});
  }

 private:
  sys::UniqueFd socket_;
  bool connected_ = false;
};

/// Waits until one of the bus's descriptors has something, and lets the bus take it.
template <typename Bus>
void serve(Bus& bus, Instant now) {
  std::vector<pollfd> waiting;
  for (const int descriptor : bus.descriptors()) {
    waiting.push_back({descriptor, POLLIN, 0});
  }
  ASSERT_GT(::poll(waiting.data(), waiting.size(), 10'000), 0);
  bus.handle_readable(now);
}

/// The port at the end of "bus NAME 127.0.0.1:PORT".
std::uint16_t port_of(const std::string& introduction) {
  return static_cast<std::uint16_t>(std::stoul(introduction.substr(introduction.rfind(':') + 1)));
}

TEST(LiveTcpBus, CarriesRequestsOfSeveralConnections) {
  sim::LiveTcpBus bus({.name = "cell", .mode = sim::BusMode::tcp, .devices = {{.address = 255}}});
  ASSERT_EQ(bus.connect(), std::nullopt);
  const std::uint16_t port = port_of(bus.introduction());
  EXPECT_EQ(bus.introduction(), "bus cell 127.0.0.1:" + std::to_string(port));
  const Client one(port);
  const Client other(port);
  ASSERT_TRUE(one.connected() && other.connected());
  serve(bus, Instant(0ms));
  one.send(kTcpReadStatus);
  serve(bus, Instant(100ms));
  other.send(kTcpReadStatus);
  serve(bus, Instant(100ms));
  EXPECT_EQ(bus.next_event(), Instant(101ms));
  bus.handle_time(Instant(102ms));
  EXPECT_EQ(one.receive(), kTcpStatus);
  EXPECT_EQ(other.receive(), kTcpStatus);
  EXPECT_EQ(bus.counters_text(), "bus cell: requests 2, answers 2");
}

TEST(LiveTcpBus, ClosesWhatIsNoModbusTcp) {
  sim::LiveTcpBus bus({.name = "cell", .mode = sim::BusMode::tcp, .devices = {{.address = 255}}});
  ASSERT_EQ(bus.connect(), std::nullopt);
  const Client client(port_of(bus.introduction()));
  serve(bus, Instant(0ms));
  client.send("00 01 00 00 FF FF 01");
  serve(bus, Instant(0ms));
  EXPECT_EQ(client.receive(), "closed");
}

TEST(LiveTcpBus, VanishesAndComesBackAtTheSamePort) {
  sim::LiveTcpBus bus({.name = "cell", .mode = sim::BusMode::tcp, .devices = {{.address = 255}}});
  ASSERT_EQ(bus.connect(), std::nullopt);
  const std::uint16_t port = port_of(bus.introduction());
  const Client client(port);
  serve(bus, Instant(0ms));
  client.send(kTcpReadStatus);
  serve(bus, Instant(0ms));
  bus.disconnect();
  EXPECT_EQ(client.receive(), "closed");
  EXPECT_FALSE(Client(port).connected());
  EXPECT_TRUE(bus.descriptors().empty());
  EXPECT_EQ(bus.next_event(), std::nullopt);
  ASSERT_EQ(bus.connect(), std::nullopt);
  EXPECT_EQ(port_of(bus.introduction()), port);
  EXPECT_TRUE(Client(port).connected());
}

TEST(LiveTcpBus, SaysWhereItCannotListen) {
  sim::LiveTcpBus bus({.name = "a", .mode = sim::BusMode::tcp});
  ASSERT_EQ(bus.connect(), std::nullopt);
  const std::uint16_t port = port_of(bus.introduction());
  sim::LiveTcpBus other(
      {.name = "b", .mode = sim::BusMode::tcp, .listen = sim::ListenAddress{"127.0.0.1", port}});
  EXPECT_EQ(other.connect(), "bus b: cannot listen on 127.0.0.1:" + std::to_string(port) +
                                 ": Address already in use");
}

TEST(SerialOverTcp, CarriesRawFramesForOneClient) {
  sim::LiveBus bus({.name = "a",
                    .listen = sim::ListenAddress{},
                    .wire = {.paced = false, .clocking = sim::Clocking::real_time},
                    .devices = {{.address = 1}}});
  ASSERT_EQ(bus.connect(), std::nullopt);
  const std::uint16_t port = port_of(bus.introduction());
  EXPECT_EQ(bus.introduction(), "bus a 127.0.0.1:" + std::to_string(port));
  {
    const Client client(port);
    serve(bus, Instant(0ms));
    client.send(kReadStatus);
    serve(bus, Instant(100ms));
    EXPECT_EQ(client.receive(), kStatus);
    const Client second(port);
    serve(bus, Instant(150ms));
    EXPECT_EQ(second.receive(), "closed");
  }
  const Client next(port);
  serve(bus, Instant(200ms));
  next.send("01 03 00 01 00 01 D5 CA");
  serve(bus, Instant(300ms));
  EXPECT_EQ(next.receive(), kStatus);
  bus.disconnect();
  EXPECT_EQ(next.receive(), "closed");
}

TEST(SerialOverTcp, CarriesAscii) {
  sim::LiveBus bus({.name = "a",
                    .mode = sim::BusMode::ascii,
                    .listen = sim::ListenAddress{},
                    .wire = {.framing = sim::Framing::ascii,
                             .paced = false,
                             .clocking = sim::Clocking::real_time},
                    .devices = {{.address = 2, .model = ModelKind::fda6000}}});
  ASSERT_EQ(bus.connect(), std::nullopt);
  const Client client(port_of(bus.introduction()));
  serve(bus, Instant(0ms));
  client.send("3A 30 32 30 36 30 30 30 31 30 30 30 33 46 34 0D 0A");
  serve(bus, Instant(100ms));
  EXPECT_EQ(client.receive(), "3A 30 32 30 36 30 30 30 31 30 30 30 33 46 34 0D 0A");
}

}  // namespace
}  // namespace mbgate::test
