// SPDX-License-Identifier: Apache-2.0
// The machine with real sockets and a pseudo-terminal for wires.
#include "io/gateway_driver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <thread>

#include "io/clients/listening_socket.hpp"
#include "run_until.hpp"
#include "unit/io/clients/socket_pair.hpp"
#include "unit/sys/pseudo_terminal.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;
using gateway::BusId;
using gateway::ListenerId;

/// Transaction 0x1234, unit 5: read two holding registers from 0x0010.
const std::string kRequest{"\x12\x34\x00\x00\x00\x06\x05\x03\x00\x10\x00\x02", 12};
/// The same on the line.
const std::string kRequestPdu{"\x03\x00\x10\x00\x02", 5};
const std::string kAnswerPdu{"\x03\x04\xAA\xBB\xCC\xDD", 6};
const std::string kAnswer{"\x12\x34\x00\x00\x00\x07\x05\x03\x04\xAA\xBB\xCC\xDD", 13};
/// Exception 0A: the line is not open.
const std::string kUnavailable{"\x12\x34\x00\x00\x00\x03\x05\x83\x0A", 9};

std::string frame_of(std::uint8_t unit, const std::string& pdu) {
  const modbus::RtuBytes frame = modbus::encode_rtu(
      unit, modbus::Pdu::from(std::vector<std::uint8_t>(pdu.begin(), pdu.end())).value());
  return {frame.begin(), frame.end()};
}

class GatewayDriverTest : public testing::Test, public DriverObserver {
 protected:
  void on_event(const gateway::Event& event) override {
    opened_ += std::holds_alternative<gateway::BusOpened>(event) ? 1 : 0;
  }
  void on_line_warning(BusId /*bus*/, const std::string& warning) override {
    ADD_FAILURE() << warning;
  }
  void on_line_failure(BusId /*bus*/, const std::string& why) override { failures_.push_back(why); }
  void on_accept_failure(ListenerId /*listener*/, const std::string& why) override {
    ADD_FAILURE() << why;
  }
  void on_tls_refusal(const TlsPlace& /*place*/, const std::string& /*why*/) override {}
  void on_stall(std::chrono::milliseconds /*lasted*/) override {}
  void on_status_changed() override {}
  void on_finished() override { finished_ = true; }

  void make_driver(const std::string& path, bus::Duration timeout = std::chrono::seconds(10)) {
    bus::LineSettings line;
    line.device = path;
    line.format = {8, modbus::Parity::none, 1};
    make_driver(line, timeout);
  }
  /// A transparent listener of one bus.
  void make_driver(const bus::LineSettings& attached,
                   bus::Duration timeout = std::chrono::seconds(10)) {
    gateway::Settings settings;
    settings.listeners.push_back(loopback_listener());
    settings.listeners[0].bus = BusId{0};
    bus::BusSettings line;
    line.name = "line";
    line.line = attached;
    line.frame_gap = bus::Duration::zero();
    line.listen_first = bus::Duration::zero();
    line.timing.response_timeout = timeout;
    settings.buses.push_back(line);
    tcp::acceptor acceptor = *bind_listener(context_, settings.listeners[0]);
    address_ = acceptor.local_endpoint();
    driver_.emplace(context_, std::move(settings), *this, nullptr, clock_);
    driver_->add_server(ListenerId{0}, std::move(acceptor));
  }
  bool wait_for(const std::function<bool()>& happened) { return run_until(context_, happened); }
  std::string receive(TestClient& client, std::size_t size) {
    std::string bytes;
    wait_for([&] {
      bytes += client.receive();
      return bytes.size() >= size;
    });
    return bytes;
  }
  /// Answers the one request on the line.
  void serve(const sys::PseudoTerminal& terminal) {
    std::string frame;
    const std::string expected = frame_of(5, kRequestPdu);
    ASSERT_TRUE(wait_for([&] {
      frame += terminal.read();
      return frame.size() >= expected.size();
    }));
    EXPECT_EQ(frame, expected);
    const std::string answer = frame_of(5, kAnswerPdu);
    ASSERT_TRUE(terminal.write(std::vector<std::uint8_t>(answer.begin(), answer.end())));
  }

  boost::asio::io_context context_;
  tcp::endpoint address_;
  std::optional<GatewayDriver> driver_;
  Clock clock_ = now;
  int opened_ = 0;
  bool finished_ = false;
  std::vector<std::string> failures_;
};

/// The computer is suspended for so long, again and again.
std::chrono::hours suspended_{0};  // NOLINT: a clock has no place for it
bus::Instant clock_that_goes_on() { return now() + suspended_; }

// The first one is on the wire, and the second one waits behind it, when the computer is suspended.
TEST_F(GatewayDriverTest, DeadlinesGoOnWhileTheComputerIsSuspended) {
  const sys::PseudoTerminal terminal;
  suspended_ = std::chrono::hours(0);
  clock_ = clock_that_goes_on;
  make_driver(terminal.path());
  driver_->start();
  ASSERT_TRUE(wait_for([&] { return opened_ == 1; }));
  TestClient client(context_, address_);
  const std::string write{"\x12\x35\x00\x00\x00\x06\x05\x06\x00\x10\x00\x02", 12};
  ASSERT_TRUE(client.send(kRequest + write));
  const std::string frame = frame_of(5, kRequestPdu);
  std::string left;
  ASSERT_TRUE(wait_for([&] {
    left += terminal.read();
    return left.size() >= frame.size();
  }));
  suspended_ = std::chrono::hours(1);
  const std::string answer = frame_of(5, kAnswerPdu);
  ASSERT_TRUE(terminal.write(std::vector<std::uint8_t>(answer.begin(), answer.end())));
  const std::string refused{"\x12\x35\x00\x00\x00\x03\x05\x86\x06", 9};
  const std::string answers = receive(client, kAnswer.size() + refused.size());
  EXPECT_NE(answers.find(refused), std::string::npos);
  EXPECT_EQ(terminal.read(), "");
}

TEST_F(GatewayDriverTest, CarriesARequestToTheLineAndItsAnswerBack) {
  const sys::PseudoTerminal terminal;
  make_driver(terminal.path());
  driver_->start();
  ASSERT_TRUE(wait_for([&] { return opened_ == 1; }));
  TestClient client(context_, address_);
  ASSERT_TRUE(client.send(kRequest));
  serve(terminal);
  EXPECT_EQ(receive(client, kAnswer.size()), kAnswer);
  EXPECT_EQ(driver_->status().clients, 1U);
  EXPECT_EQ(driver_->status().buses_open, 1U);
}

TEST_F(GatewayDriverTest, CarriesARequestToASerialDeviceServer) {
  tcp::acceptor server(context_, {boost::asio::ip::address_v4::loopback(), 0});
  bus::LineSettings line;
  line.remote = bus::Endpoint{"127.0.0.1", server.local_endpoint().port()};
  make_driver(line);
  driver_->start();
  ASSERT_TRUE(wait_for([&] { return opened_ == 1; }));
  TestClient adapter(server.accept());
  TestClient client(context_, address_);
  ASSERT_TRUE(client.send(kRequest));
  const std::string expected = frame_of(5, kRequestPdu);
  EXPECT_EQ(receive(adapter, expected.size()), expected);
  ASSERT_TRUE(adapter.send(frame_of(5, kAnswerPdu)));
  EXPECT_EQ(receive(client, kAnswer.size()), kAnswer);
}

TEST_F(GatewayDriverTest, AcceptsFromASocketThatComesLater) {
  const sys::PseudoTerminal terminal;
  make_driver(terminal.path());
  driver_->start();
  tcp::acceptor acceptor = *bind_listener(context_, loopback_listener());
  const TestClient client(context_, acceptor);
  driver_->add_server(ListenerId{0}, std::move(acceptor));
  EXPECT_TRUE(wait_for([&] { return driver_->status().clients == 1; }));
}

TEST_F(GatewayDriverTest, AnswersAClientThatHalfClosed) {
  const sys::PseudoTerminal terminal;
  make_driver(terminal.path());
  driver_->start();
  ASSERT_TRUE(wait_for([&] { return opened_ == 1; }));
  TestClient client(context_, address_);
  ASSERT_TRUE(client.send(kRequest));
  client.send_fin();
  serve(terminal);
  EXPECT_EQ(receive(client, kAnswer.size()), kAnswer);
  bool ended = false;
  EXPECT_TRUE(wait_for([&] {
    client.receive(&ended);
    return ended;
  }));
  EXPECT_EQ(driver_->status().clients, 0U);
}

TEST_F(GatewayDriverTest, ServesWithoutThePortAndOpensItWhenItComes) {
  const auto link =
      std::filesystem::temp_directory_path() / ("mbgate-driver-" + std::to_string(::getpid()));
  std::filesystem::remove(link);
  make_driver(link.string());
  driver_->start();
  TestClient client(context_, address_);
  ASSERT_TRUE(client.send(kRequest));
  EXPECT_EQ(receive(client, kUnavailable.size()), kUnavailable);
  ASSERT_TRUE(wait_for([&] { return !failures_.empty(); }));
  EXPECT_EQ(failures_[0], "cannot open " + link.string() + ": No such file or directory");
  const sys::PseudoTerminal terminal;
  std::filesystem::create_symlink(terminal.path(), link);
  EXPECT_TRUE(wait_for([&] { return opened_ == 1; }));
  std::filesystem::remove(link);
  ASSERT_TRUE(client.send(kRequest));
  serve(terminal);
  EXPECT_EQ(receive(client, kAnswer.size()), kAnswer);
}

TEST_F(GatewayDriverTest, SurvivesALineThatGoesInTheMiddleOfARequest) {
  sys::PseudoTerminal terminal;
  make_driver(terminal.path());
  driver_->start();
  ASSERT_TRUE(wait_for([&] { return opened_ == 1; }));
  TestClient client(context_, address_);
  ASSERT_TRUE(client.send(kRequest));
  ASSERT_TRUE(wait_for([&] { return !terminal.read().empty(); }));
  terminal.unplug();
  // It was on the wire: 0B.
  const std::string expected{"\x12\x34\x00\x00\x00\x03\x05\x83\x0B", 9};
  EXPECT_EQ(receive(client, expected.size()), expected);
  ASSERT_FALSE(failures_.empty());
  EXPECT_EQ(failures_[0], terminal.path() + ": the device has gone");
}

TEST_F(GatewayDriverTest, FinishesAndClosesItsClients) {
  const sys::PseudoTerminal terminal;
  make_driver(terminal.path());
  driver_->start();
  TestClient client(context_, address_);
  ASSERT_TRUE(wait_for([&] { return driver_->status().clients == 1; }));
  driver_->shutdown();
  EXPECT_TRUE(wait_for([&] { return finished_; }));
  bool ended = false;
  client.receive(&ended);
  EXPECT_TRUE(ended);
  EXPECT_THROW(TestClient(context_, address_), boost::system::system_error);
}

// It has seen an empty socket; then the process is stopped, before it has looked at its clock.
TEST_F(GatewayDriverTest, WhatComesWhileItStandsStillBehindAReadingIsOld) {
  const sys::PseudoTerminal terminal;
  make_driver(terminal.path(), std::chrono::milliseconds(10));
  driver_->start();
  ASSERT_TRUE(wait_for([&] { return opened_ == 1; }));
  TestClient client(context_, address_);
  ASSERT_TRUE(wait_for([&] { return driver_->status().clients == 1; }));
  // Unit 5: write 1 to register 0x0010. A write waits 795 ms.
  const std::string write{"\x00\x01\x00\x00\x00\x06\x05\x06\x00\x10\x00\x01", 12};
  ASSERT_TRUE(client.send(write));
  std::this_thread::sleep_for(std::chrono::milliseconds(1000));
  ConnectionEvents& events = *driver_;
  events.client_bytes(gateway::ClientId{0}, {}, 0);
  const std::string expected{"\x00\x01\x00\x00\x00\x03\x05\x86\x06", 9};
  EXPECT_EQ(receive(client, expected.size()), expected);
  EXPECT_EQ(terminal.read(), "");
}

TEST_F(GatewayDriverTest, AcceptsWhatWaitedBeforeTheStart) {
  const sys::PseudoTerminal terminal;
  make_driver(terminal.path());
  TestClient client(context_, address_);
  // Unit 5: write 1 to register 0x0010. It is older than the process: 06.
  ASSERT_TRUE(client.send({"\x00\x01\x00\x00\x00\x06\x05\x06\x00\x10\x00\x01", 12}));
  driver_->start();
  EXPECT_EQ(driver_->status().clients, 1U);
  const std::string expected{"\x00\x01\x00\x00\x00\x03\x05\x86\x06", 9};
  EXPECT_EQ(receive(client, expected.size()), expected);
  EXPECT_EQ(terminal.read(), "");
}

}  // namespace
}  // namespace mbgate::io
